/** What the analysis `beats` says of each clip, as the bench draws it. Seconds from the first frame. */
import { partOf, rowsOf, type Result } from "../../api/results";
import type { Beat } from "../../motion/dance/dancing";

export interface Candidate {
  at: number;
  verdict: "beat" | "end" | "F1" | "F2" | "F3";
  dip: number;
  rest: number;
}
export interface Bar {
  number: number;
  from: number;
  to: number;
}
export interface Peak {
  period: number;
  bpm: number;
  strength: number;
}

export interface ClipRow {
  id: string;
  name: string;
  frames: number;
  fps: number;
  seconds: number;
  /** Every `step` frames. */
  speed: number[];
  step: number;
  mean: number;
  beats: Beat[];
  candidates: Candidate[];
  minima: number[];
  bars: Bar[];
  bpm: number | null;
  peaks: Peak[];
  from: string;
  clear: boolean | null;
  steady: number | null;
  refused: Record<string, number>;
}

type Table = Record<string, unknown> & { document: string };

export function readRows(result: Result): ClipRow[] {
  const { parts } = result;
  const series = (partOf(result, "speed").data.series ?? []) as {
    document: string;
    step: number;
    values: number[];
    mean: number;
  }[];
  const grouped = (name: string) => {
    const found = new Map<string, Table[]>();
    for (const row of rowsOf<Table>(parts[name])) found.set(row.document, [...(found.get(row.document) ?? []), row]);
    return found;
  };
  const [beats, bars, candidates] = [grouped("beats"), grouped("bars"), grouped("candidates")];
  return rowsOf<Table>(parts.clips).map((clip) => {
    const id = clip.document;
    const fps = clip.fps as number;
    const curve = series.find((one) => one.document === id);
    const minima = (candidates.get(id) ?? []).map((row) => ({
      at: row.seconds as number,
      verdict: row.verdict as Candidate["verdict"],
      dip: row.dip as number,
      rest: row.rest as number,
    }));
    return {
      id,
      fps,
      name: clip.name as string,
      frames: clip.frames as number,
      seconds: ((clip.frames as number) - 1) / fps,
      speed: curve?.values ?? [],
      step: curve?.step ?? 1,
      mean: curve?.mean ?? 0,
      beats: (beats.get(id) ?? []).map((row) => ({
        at: row.seconds as number,
        kind: clip.beats_from === "tracked" ? ("tracked" as const) : ("detected" as const),
      })),
      candidates: minima,
      minima: minima.map((one) => one.at),
      bars: (bars.get(id) ?? []).map((row) => ({
        number: row.bar as number,
        from: ((row.b0 as number) - 1) / fps,
        to: ((row.b3 as number) - 1) / fps,
      })),
      bpm: clip.bpm as number | null,
      peaks: (clip.peaks ?? []) as Peak[],
      from: String(clip.beats_from),
      clear: clip.tempo_clear as boolean | null,
      steady: clip.tempo_steady as number | null,
      refused: { F1: clip.refused_F1 as number, F2: clip.refused_F2 as number, F3: clip.refused_F3 as number },
    };
  });
}
