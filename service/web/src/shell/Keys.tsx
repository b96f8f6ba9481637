/** The keys that work now. */
import { Dialog } from "../ui/Dialog";
import { commands, commandsOf, type Command } from "../state/session/keys";
import { tourStep } from "../state/session/tour";
import { Icon } from "../ui/icons";
import { w } from "../words";

export function Keys({ onClose }: { onClose: () => void }) {
  const everywhere = new Set(commandsOf("shell"));
  const all = commands();
  const table = (title: string, list: Command[]) =>
    list.length > 0 && (
      <section>
        <h3>{title}</h3>
        <dl class="keys">
          {list.map((one) => (
            <div key={one.id}>
              <dt>
                {one.keys.map((keys) => (
                  <kbd key={keys}>{keys}</kbd>
                ))}
              </dt>
              <dd>{w(one.word)}</dd>
            </div>
          ))}
        </dl>
      </section>
    );
  return (
    <Dialog title={w("label.help")} onClose={onClose} wide>
      <p class="row wrap tour-start">
        <button
          type="button"
          class="button"
          onClick={() => {
            onClose();
            tourStep.value = 0;
          }}
        >
          <Icon name="play" />
          {w("button.startTour")}
        </button>
        <span class="dim">{w("help.tour")}</span>
      </p>
      <div class="keys-columns">
        {table(
          w("label.onThisPage"),
          all.filter((one) => !everywhere.has(one)),
        )}
        {table(
          w("label.everywhere"),
          all.filter((one) => everywhere.has(one)),
        )}
      </div>
    </Dialog>
  );
}
