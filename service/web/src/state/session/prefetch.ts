/** Loading a page's code before it is opened. */
let loadPage: (name: string) => Promise<unknown> = () => Promise.resolve();

/** How code is loaded: the shell says so, which knows the pages. */
export const followPrefetch = (load: typeof loadPage): void => void (loadPage = load);

/** Load the code of a page. A failure shows when the page is opened. */
export const prefetch = (name: string): void => void loadPage(name).catch(() => undefined);
