/** One sentence of the guided tour in a row below the page: it covers nothing, and everything stays usable. */
import { useEffect, useRef } from "preact/hooks";
import { TOUR, tourStep } from "../state/session/tour";
import { Icon } from "../ui/icons";
import { w } from "../words";

const PAGE_OPENS = 400; // ms

export function Tour() {
  const at = tourStep.value;
  const next = useRef<HTMLButtonElement>(null);
  const step = at === null ? undefined : TOUR[at];
  // Pages that open take the focus, some of them late: until the person does something, Enter goes on with the tour.
  useEffect(() => {
    if (at === null) return;
    const take = () => next.current?.focus();
    const again = (event: FocusEvent) => {
      if (event.target !== next.current) queueMicrotask(take);
    };
    const stop = () => {
      clearTimeout(timer);
      removeEventListener("focusin", again);
      removeEventListener("keydown", stop, true);
      removeEventListener("pointerdown", stop, true);
    };
    const timer = setTimeout(take, PAGE_OPENS);
    addEventListener("focusin", again);
    addEventListener("keydown", stop, true);
    addEventListener("pointerdown", stop, true);
    return stop;
  }, [at]);
  if (at === null || !step) return null;
  const isLast = at === TOUR.length - 1;
  return (
    <section class="tour row" aria-label={w("label.tour")}>
      <p class="grow" role="status">
        <span class="dim">{w("label.tourStep", { n: at + 1, of: TOUR.length })}</span> {w(step.text)}
      </p>
      {at > 0 && (
        <button type="button" class="button" onClick={() => (tourStep.value = at - 1)}>
          {w("button.tourBack")}
        </button>
      )}
      <button ref={next} type="button" class="button primary" onClick={() => (tourStep.value = isLast ? null : at + 1)}>
        {w(isLast ? "button.tourEnd" : "button.tourNext")}
      </button>
      {!isLast && (
        <button
          type="button"
          class="button quiet icon"
          aria-label={w("button.tourEnd")}
          title={w("button.tourEnd")}
          onClick={() => (tourStep.value = null)}
        >
          <Icon name="close" />
        </button>
      )}
    </section>
  );
}
