/** Questions to begin with: each finds something in this library where anything can. */
import { useEffect } from "preact/hooks";
import { inUse, loadVocabulary } from "../../state/library/vocabulary";
import { w, type Word } from "../../words";
import { literal } from "./builder";

export function Examples({ onChoose }: { onChoose: (query: string) => void }) {
  useEffect(() => void loadVocabulary(), []);
  // The name that most clips have.
  const name = [...inUse.value].sort((a, b) => b.documents - a.documents)[0]?.name ?? "left-arm-abduction";
  const examples: [Word, string][] = [
    ["label.exampleName", `//frame[motion_name = ${literal(name)}]`],
    ["label.exampleBent", "//frame[frame_bone[@name = 'left_low_arm']/@Rx > 45]"],
    ["label.exampleBegin", "//frame[position() <= 30]"],
    ["label.exampleNot", `//frame[not(motion_name = ${literal(name)})]`],
    ["label.exampleNames", "distinct-values(//motion_name)"],
    ["label.exampleCount", "count(//frame)"],
    ["label.exampleBones", "//bone[name = 'Head']"],
    ["label.exampleClips", "//header[starts-with(@filename, 'walk')]"],
  ];
  return (
    <div class="empty examples-page">
      <h2>{w("help.xpathStart")}</h2>
      <p class="dim">{w("label.xpathExamples")}</p>
      <ul class="examples">
        {examples.map(([word, query]) => (
          <li key={word}>
            <button type="button" class="example" onClick={() => onChoose(query)}>
              <span>{w(word)}</span>
              <code>{query}</code>
            </button>
          </li>
        ))}
      </ul>
    </div>
  );
}
