/** The rows that an expression says, where rows can say it. */
import { itemAt } from "../../../lists";
import {
  CHANNELS,
  COMPARISONS,
  type Condition,
  type MeasureRow,
  type QuantityName,
  type Question,
  type Row,
} from "./question";

const TOKEN = /\s*('[^']*'|"[^"]*"|-?\d+(?:\.\d+)?|[A-Za-z_][\w.:-]*|\/\/|!=|<=|>=|[[\](),=<>@/.])/y;
const MEASURED: readonly QuantityName[] = ["speed", "height", "angle", "distance"];

/** A bound of frame numbers: two of them are a row. */
type Bound = { kind: "bound"; than: ">=" | "<="; value: number };
type Part = Condition | Bound | { kind: "group"; group: Group } | { kind: "later"; within: number; group: Group };
interface Group {
  by: "and" | "or";
  parts: Part[];
}

class Beyond extends Error {}
const fail = (): never => {
  throw new Beyond();
};

/** The question that a text says; null where rows cannot say it. `all` is that of before, where the text leaves it open. */
export function questionOf(text: string, all: boolean): Question | null {
  try {
    const reader = new Reader(text);
    const group = reader.query();
    const found: { rows: Row[]; all: boolean | null } = { rows: [], all: null };
    addStep(group, undefined, found);
    return { rows: found.rows, all: found.all ?? all };
  } catch (error) {
    if (error instanceof Beyond) return null;
    throw error;
  }
}

/** Rows of one frame, and those of the frames after it. */
function addStep(group: Group, within: number | undefined, found: { rows: Row[]; all: boolean | null }): void {
  const flat = flatten(group);
  const later = flat.parts.filter((one) => one.kind === "later");
  let own: Group = { by: flat.by, parts: flat.parts.filter((one) => one.kind !== "later") };
  if (later.length > 1 || (later[0] && (flat.by === "or" || flat.parts.at(-1) !== later[0]))) fail();
  // "(a or b) and then …": the group in parentheses is all that this frame says.
  const [only] = own.parts;
  if (own.parts.length === 1 && only?.kind === "group") own = flatten(only.group);
  const conditions = listConditions(own);
  if (!conditions.length && later.length) fail();
  if (conditions.length > 1) {
    if (found.all !== null && found.all !== (own.by === "and")) fail();
    found.all = own.by === "and";
  }
  conditions.forEach((one, at) => found.rows.push(at || within === undefined ? one : { ...one, within }));
  if (later[0]?.kind === "later") addStep(later[0].group, later[0].within, found);
}

/** A group without groups that are joined as it is. */
function flatten({ by, parts }: Group): Group {
  return {
    by,
    parts: parts.flatMap((one) => {
      if (one.kind !== "group") return [one];
      const inner = flatten(one.group);
      return inner.by === by || inner.parts.length === 1 ? inner.parts : [{ kind: "group" as const, group: inner }];
    }),
  };
}

function listConditions({ by, parts }: Group): Condition[] {
  const found: Condition[] = [];
  for (let at = 0; at < parts.length; at++) {
    const part = itemAt(parts, at);
    if (part.kind === "group") found.push(...framesIn(part.group));
    else if (part.kind === "bound") {
      if (by === "or") fail();
      found.push(...framesIn({ by, parts: parts.slice(at, at + 2) }));
      at++;
    } else if (part.kind === "later") fail();
    else found.push(part);
  }
  return found;
}

function framesIn({ by, parts }: Group): Condition[] {
  const [first, last] = parts;
  if (by !== "and" || parts.length !== 2 || first?.kind !== "bound" || last?.kind !== "bound") return fail();
  if (first.than !== ">=" || last.than !== "<=" || first.value > last.value) return fail();
  return [{ kind: "frames", first: first.value, last: last.value }];
}

class Reader {
  private readonly tokens: string[] = [];
  private at = 0;

  constructor(text: string) {
    TOKEN.lastIndex = 0;
    let end = 0;
    for (let match = TOKEN.exec(text); match; match = TOKEN.exec(text)) {
      this.tokens.push(match[1] ?? "");
      end = TOKEN.lastIndex;
    }
    if (text.slice(end).trim()) fail();
  }

  query(): Group {
    this.take("//", "frame");
    const parts: Part[] = [];
    while (this.sees("[")) parts.push({ kind: "group", group: this.predicate() });
    if (this.at < this.tokens.length) fail();
    return { by: "and", parts };
  }

  private predicate(): Group {
    this.take("[");
    const group = this.group();
    this.take("]");
    return group;
  }

  /** Parts with `or` between them, or with `and`. */
  private group(): Group {
    const first = this.conjunction();
    if (!this.sees("or")) return first;
    const either = [first];
    while (this.sees("or")) {
      this.take("or");
      either.push(this.conjunction());
    }
    return { by: "or", parts: either.map((group) => ({ kind: "group" as const, group })) };
  }

  private conjunction(): Group {
    const parts = [this.part()];
    while (this.sees("and")) {
      this.take("and");
      parts.push(this.part());
    }
    return { by: "and", parts };
  }

  private part(): Part {
    const token = this.next();
    if (token === "(") {
      const group = this.group();
      this.take(")");
      return { kind: "group", group };
    }
    if (token === "not") return this.negation();
    if (token === "motion_name") return this.label();
    if (token === "frame_bone") return this.sample();
    if (token === "position") return this.bound();
    if (token === "mo:contact" || token === "mo:activity") return this.truth(token, true);
    if (token === "mo:window") return this.later();
    const quantity = MEASURED.find((one) => token === `mo:${one}`);
    return quantity ? this.measure(quantity) : fail();
  }

  private negation(): Condition {
    this.take("(");
    const token = this.next();
    let found: Condition;
    if (token === "motion_name") {
      this.take("=");
      found = { kind: "name", is: "not", name: this.text() };
    } else found = token === "mo:contact" || token === "mo:activity" ? this.truth(token, false) : fail();
    this.take(")");
    return found;
  }

  private truth(token: string, is: boolean): Condition {
    const [name = ""] = this.texts(1);
    return token === "mo:contact" ? { kind: "contact", is, joint: name } : { kind: "activity", is, name };
  }

  private label(): Condition {
    if (!this.sees("[")) {
      this.take("=");
      return { kind: "name", is: "is", name: this.text() };
    }
    this.take("[", "contains", "(", ".", ",");
    const name = this.text();
    this.take(")", "]");
    return { kind: "name", is: "contains", name };
  }

  private sample(): Condition {
    this.take("[", "@", "name", "=");
    const bone = this.text();
    this.take("]", "/", "@");
    const name = this.next();
    const channel = CHANNELS.find((one) => one === name) ?? fail();
    const sign = this.next();
    const than = COMPARISONS.find((one) => one === sign) ?? fail();
    return { kind: "value", bone, channel, than, value: this.number() };
  }

  private bound(): Bound {
    this.take("(", ")");
    const sign = this.next();
    const than = sign === ">=" || sign === "<=" ? sign : fail();
    return { kind: "bound", than, value: this.number() };
  }

  private later(): Part {
    this.take("(", "0", ",");
    const within = this.number();
    this.take(")");
    return within > 0 ? { kind: "later", within, group: this.predicate() } : fail();
  }

  private measure(quantity: QuantityName): MeasureRow {
    const [joint = "", other = ""] = this.texts(quantity === "distance" ? 2 : 1);
    const sign = this.next();
    const than = sign === ">" || sign === "<" ? sign : fail();
    if (quantity === "height" && this.sees("mo:height")) {
      this.take("mo:height");
      const [over = ""] = this.texts(1);
      return { kind: "measure", quantity: "above", joint, other: over, than, value: 0 };
    }
    return { kind: "measure", quantity, joint, other, than, value: this.number() };
  }

  /** Arguments of a function that are texts. */
  private texts(count: number): string[] {
    this.take("(");
    const found = [this.text()];
    while (found.length < count) {
      this.take(",");
      found.push(this.text());
    }
    this.take(")");
    return found;
  }

  private text(): string {
    const token = this.next();
    if (/^['"]/.test(token)) return token.slice(1, -1);
    if (token !== "concat") return fail();
    this.take("(");
    let found = this.text();
    while (this.sees(",")) {
      this.take(",");
      found += this.text();
    }
    this.take(")");
    return found;
  }

  private number(): number {
    const token = this.next();
    return /^-?\d/.test(token) ? Number(token) : fail();
  }

  private sees(token: string): boolean {
    return this.tokens[this.at] === token;
  }

  private next(): string {
    return this.tokens[this.at++] ?? fail();
  }

  private take(...tokens: string[]): void {
    for (const token of tokens) if (this.next() !== token) fail();
  }
}
