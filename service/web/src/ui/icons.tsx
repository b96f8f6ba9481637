/** The icons: one 16 px stroke set. */
const PATHS = {
  library: "M2.5 2.5h4.5v4.5h-4.5zM9 2.5h4.5v4.5H9zM2.5 9h4.5v4.5h-4.5zM9 9h4.5v4.5H9z",
  xpath: "M2.5 4l4 4-4 4M8.5 12.5h5",
  compose: "M2 3.5h7v3H2zM7 9.5h7v3H7z",
  retarget: "M4 3.5v9M1.5 6h5M12 3.5v9M9.5 6h5M6.5 12.5h3m-1.2-1.5l1.5 1.5-1.5 1.5",
  reach:
    "M4.5 2.5v4M4.5 9.5v4M4.5 6.500a1.5 1.5 0 1 1 0 3 1.5 1.500 0 0 1 0-3M11.5 2.5v1.500M11.5 7v6.5M11.5 4a1.5 1.5 0 1 1 0 3 1.5 1.500 0 0 1 0-3",
  beat: "M1.5 8.500h2.500L6 3.500l3 9.500 2-6 1 1.500h2.500",
  path: "M3.5 10.5a1.5 1.5 0 1 0 0 3 1.5 1.5 0 0 0 0-3zM12.5 2.5a1.5 1.5 0 1 0 0 3 1.5 1.5 0 0 0 0-3zM5 12h5a2.250 2.250 0 0 0 0-4H6a2.250 2.250 0 0 1 0-4h5",
  face: "M8 2a6 6 0 1 0 0 12A6 6 0 0 0 8 2zM5.5 6.500v.3M10.5 6.500v.3M5.200 9.500a3.4 3.4 0 0 0 5.600 0",
  chart: "M2.5 2.500v11h11M5 10.500l2.500-3.500 2.500 2 3-4.500",
  settings: "M3 4.5h6m3 0h1M3 11.5h2m3 0h5M9 3v3h2.5V3zM5.5 10v3H8v-3z",
  search: "M7 2.5a4.5 4.5 0 1 0 0 9 4.5 4.5 0 0 0 0-9zM10.3 10.3L14 14",
  play: "M4.5 2.5v11l9-5.5z",
  pause: "M4.5 3v10M11.5 3v10",
  first: "M3.5 3v10M13 3L6.5 8l6.5 5z",
  last: "M12.5 3v10M3 3l6.5 5L3 13z",
  back: "M11 3L5 8l6 5z",
  next: "M5 3l6 5-6 5z",
  loop: "M3 7V6a2.5 2.5 0 0 1 2.5-2.500h7M10.5 1.500l2 2-2 2M13 9v1a2.5 2.5 0 0 1-2.5 2.500h-7M5.5 14.500l-2-2 2-2",
  close: "M3.5 3.5l9 9M12.5 3.5l-9 9",
  down: "M4 6l4 4 4-4",
  arrow: "M8 3v10M4.5 9.500L8 13l3.500-3.500",
  right: "M6 4l4 4-4 4",
  undo: "M5.5 2.500L2.5 5.500l3 3M2.5 5.500H10a3.5 3.5 0 0 1 0 7H6",
  redo: "M10.5 2.500l3 3-3 3M13.5 5.500H6a3.5 3.5 0 0 0 0 7h4",
  export: "M8 10V2M5 4.5L8 1.800l3 2.700M2.5 9.500v4h11v-4",
  upload: "M8 2v8M5 7.500L8 10.300l3-2.800M2.5 11v2.500h11V11",
  check: "M3 8.500l3.5 3.500L13 4.5",
  warn: "M8 2L14.5 13.500h-13zM8 6.500v3M8 11.500v.3",
  trash: "M3 4.500h10M6 4V2.500h4V4M4.5 4.500l.7 9h5.600l.7-9",
  list: "M2.5 4h11M2.5 8h11M2.5 12h11",
  plus: "M8 3v10M3 8h10",
  help: "M5.5 6a2.5 2.5 0 1 1 3.5 2.300c-.7.3-1 .7-1 1.500M8 12.300v.3",
  code: "M5.5 4.500L2 8l3.500 3.500M10.500 4.500L14 8l-3.500 3.500M9 3l-2 10",
  eye: "M1.5 8S4 3.5 8 3.5 14.5 8 14.5 8 12 12.5 8 12.5 1.5 8 1.5 8zM8 6.200a1.8 1.8 0 1 0 0 3.6 1.8 1.8 0 0 0 0-3.600z",
  more: "M3.5 8h.1M8 8h.1M12.5 8h.1",
  label: "M2.5 3.500h6l5 4.5-5 4.500h-6z",
  layer: "M8 2L14 5.500 8 9 2 5.500zM2 9l6 3.500L14 9",
  folder: "M2 4.500v8h12v-7H8L6.500 3.500H2z",
  filter: "M2.5 4h11M4.500 8h7M6.500 12h3",
  mirror: "M8 2v12M6 4.500L2 11.500h4zM10 4.500l4 7h-4z",
} as const;

export type IconName = keyof typeof PATHS;
export const icons = Object.keys(PATHS);

export function Icon({ name }: { name: IconName }) {
  const solid = /^(play|back|next)$/.test(name);
  return (
    <svg
      width="16"
      height="16"
      viewBox="0 0 16 16"
      aria-hidden="true"
      fill={solid ? "currentColor" : "none"}
      stroke="currentColor"
      stroke-width={name === "more" ? 2.5 : 1.5}
      stroke-linecap="round"
      stroke-linejoin="round"
    >
      <path d={PATHS[name]} />
    </svg>
  );
}
