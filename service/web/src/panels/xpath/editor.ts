/** The XPath editor: CodeMirror with colours, completion from the server, Ctrl+Enter. */
import {
  autocompletion,
  completionKeymap,
  closeBrackets,
  closeBracketsKeymap,
  type CompletionContext,
  type CompletionResult,
} from "@codemirror/autocomplete";
import { defaultKeymap, history, historyKeymap } from "@codemirror/commands";
import { HighlightStyle, StreamLanguage, syntaxHighlighting } from "@codemirror/language";
import { EditorState, Prec } from "@codemirror/state";
import { EditorView, keymap, placeholder } from "@codemirror/view";
import { tags } from "@lezer/highlight";
import { get } from "../../api/client";
import { editorTheme } from "../../ui/editorTheme";
import { w } from "../../words";

const AXES =
  /^(ancestor-or-self|ancestor|attribute|child|descendant-or-self|descendant|following-sibling|following|namespace|parent|preceding-sibling|preceding|self)(?=::)/;

/** Words of XPath 3.1 and of FLWOR where no name may stand: behind a value, or before a variable. */
const BETWEEN =
  /^(and|or|div|idiv|mod|to|in|return|satisfies|then|else|union|except|intersect|is|eq|ne|lt|le|gt|ge|instance|treat|castable|cast|of|as|where|(order|group)(?=\s+by\s)|stable(?=\s+order)|by|ascending|descending|empty(?=\s+(greatest|least))|greatest|least|allowing|(at|count)(?=\s+\$))(?![\w.-])/;
const BEFORE_VARIABLE = /^(for|let|some|every)(?=\s+\$)/;
const isBehindValue = (before: string) => /[\w.\])"'*]\s+$|[\])"']$/.test(before);

const xpath = StreamLanguage.define<{ dummy: boolean }>({
  startState: () => ({ dummy: true }),
  token(stream) {
    if (stream.eatSpace()) return null;
    if (stream.match(/^"[^"]*"?|^'[^']*'?/)) return "string";
    if (stream.match(/^\d+(\.\d*)?|^\.\d+/)) return "number";
    if (stream.match(/^\(:.*?(:\)|$)/)) return "comment";
    if (stream.match(AXES)) return "keyword";
    if (stream.match(/^@[\w:.-]+/)) return "attributeName";
    if (stream.match(/^\$[\w.-]+/)) return "variableName";
    if (stream.match(BEFORE_VARIABLE)) return "operatorKeyword";
    if (isBehindValue(stream.string.slice(0, stream.pos)) && stream.match(BETWEEN)) return "operatorKeyword";
    if (stream.match(/^[\w:.-]+(?=\s*\()/)) return "keyword";
    if (stream.match(/^[\w:.-]+/)) return "typeName";
    stream.next();
    return "operator";
  },
});

const colours = HighlightStyle.define([
  { tag: tags.string, color: "var(--good)" },
  { tag: tags.number, color: "var(--name5)" },
  { tag: tags.keyword, color: "var(--accent)" },
  { tag: tags.operatorKeyword, color: "var(--accent)" },
  { tag: tags.attributeName, color: "var(--right)" },
  { tag: tags.variableName, color: "var(--name5)" },
  { tag: tags.typeName, color: "var(--left)" },
  { tag: tags.comment, color: "var(--text3)" },
]);

async function complete(context: CompletionContext): Promise<CompletionResult | null> {
  const text = context.state.doc.toString();
  try {
    const answer = await get("/xpath/complete", { query: { q: text, at: context.pos } });
    if (!answer.items.length) return null;
    return {
      from: answer.first,
      options: answer.items.map((one) => ({
        label: one.text,
        detail: typeof one.documents === "number" ? w("label.clips", { n: one.documents }) : one.detail,
        type: one.kind.includes("name") ? "constant" : one.kind,
      })),
      validFor: /^[\w.-]*$/,
    };
  } catch {
    return null; // Completion is help; trouble is told when the question is asked.
  }
}

/** Mounted in a shadow root: the editor's styles are adopted sheets there, which a strict policy allows. */
export function mountXPath(
  host: HTMLElement,
  text: string,
  onChange: (text: string) => void,
  onRun: () => void,
): EditorView {
  const shadow = host.shadowRoot ?? host.attachShadow({ mode: "open" });
  const inner = document.createElement("div");
  shadow.replaceChildren(inner);
  const made = new EditorView({
    parent: inner,
    root: shadow,
    state: EditorState.create({
      doc: text,
      extensions: [
        Prec.highest(keymap.of([{ key: "Mod-Enter", run: () => (onRun(), true) }])),
        keymap.of([...closeBracketsKeymap, ...completionKeymap, ...historyKeymap, ...defaultKeymap]),
        history(),
        closeBrackets(),
        autocompletion({ override: [complete], activateOnTyping: true }),
        xpath,
        syntaxHighlighting(colours),
        EditorView.lineWrapping,
        editorTheme,
        placeholder(w("label.queryPlaceholder")),
        EditorView.contentAttributes.of({ "aria-label": w("label.xpath") }),
        EditorView.updateListener.of((update) => update.docChanged && onChange(update.state.doc.toString())),
      ],
    }),
  });
  made.scrollDOM.tabIndex = 0; // What scrolls is reached by keys.
  return made;
}
