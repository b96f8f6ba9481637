/** A page that opens has the focus on its heading, so that keys and readers begin there and not at the frame around it. */
export function focusHeading(main: HTMLElement): () => void {
  let given: HTMLElement | null = null;
  const look = () => {
    // A heading that came in place of the one before it takes over; where somebody went meanwhile, nothing moves.
    if (document.activeElement !== document.body || given?.isConnected) return;
    const heading = main.querySelector("h1");
    if (!heading) return;
    given = heading;
    heading.tabIndex = -1;
    heading.focus({ preventScroll: true });
  };
  const observer = new MutationObserver(look);
  observer.observe(main, { childList: true, subtree: true });
  look();
  return () => observer.disconnect();
}
