/** What a person sets once for this browser. */
import type { Signal } from "@preact/signals";
import { useEffect } from "preact/hooks";
import { subject } from "../../shell/Bar";
import { language, singleKeys, swapSides, theme, timeAs } from "../../state/settings";
import { w } from "../../words";
import { Account } from "./Account";
import "../../styles/settings.css";

export function Segments<T extends string | boolean>({ value, options, label }: { value: Signal<T>; options: [T, string][]; label: string }) {
  return (
    <div class="segments" role="group" aria-label={label}>
      {options.map(([one, text]) => (
        <button key={String(one)} type="button" aria-pressed={value.value === one} onClick={() => (value.value = one)}>{text}</button>
      ))}
    </div>
  );
}

export function SettingsPage() {
  useEffect(() => { subject.value = null; }, []);
  return (
    <div class="page-pad">
      <h1>{w("settings")}</h1>
      <div class="form">
        <span>{w("theme")}</span>
        <Segments label={w("theme")} value={theme} options={[["dark", w("dark")], ["light", w("light")], ["system", w("system")]]} />
        <span>{w("language")}</span>
        <Segments label={w("language")} value={language} options={[["en", "English"], ["ko", "한국어"]]} />
        <span>{w("sides")}</span>
        <Segments label={w("sides")} value={swapSides} options={[[false, w("sidesUsual")], [true, w("sidesSwapped")]]} />
        <span>{w("timeAs")}</span>
        <Segments label={w("timeAs")} value={timeAs} options={[["frame", w("frameNumbers")], ["seconds", w("seconds")], ["timecode", w("timecode")]]} />
        <label for="single">{w("singleKeys")}</label>
        <span class="row"><input id="single" type="checkbox" checked={singleKeys.value} onChange={(event) => (singleKeys.value = event.currentTarget.checked)} /><span class="dim">{w("singleKeysHelp")}</span></span>
      </div>
      <Account />
    </div>
  );
}
