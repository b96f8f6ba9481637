/** What somebody shared: clips that play, and what they may be saved as. */
import { effect } from "@preact/signals";
import { useEffect, useMemo, useState } from "preact/hooks";
import { address, ask, below, type Schemas } from "../../api/client";
import { motionOf, type Motion } from "../../motion/loading/source";
import { Player } from "../../state/clip/player";
import { language } from "../../state/session/settings";
import { Icon } from "../../ui/icons";
import { Menu } from "../../ui/Menu";
import { MotionView, type Actor } from "../../ui/playing/MotionView";
import { PlayBar } from "../../ui/playing/PlayBar";
import { Trouble } from "../../ui/Trouble";
import { useAsync } from "../../ui/useAsync";
import { duration, w } from "../../words";

export function SharedPage({ secret }: { secret: string }) {
  // The secret goes in a body: what stands in addresses comes into logs.
  const opened = useAsync(() => exchanged(secret), [secret]);
  const [at, setAt] = useState(0);
  const shared = opened.value;
  useEffect(() => {
    if (shared) document.title = `${shared.name} · MCML Repository`;
  }, [shared]);
  if (opened.error)
    return (
      <main class="shared-page">
        <div class="empty">
          <h1>MCML Repository</h1>
          <Trouble error={opened.error} />
        </div>
      </main>
    );
  if (!shared) return null;
  const one = shared.documents[at];
  const until = new Intl.DateTimeFormat(language.value, { dateStyle: "long" }).format(new Date(shared.expires));
  return (
    <main class="shared-page">
      <header class="row wrap">
        <h1 class="cut">{one?.name ?? shared.name}</h1>
        <span class="dim grow">{one && duration(one.frames * (one.seconds_per_frame ?? 0))}</span>
        <span class="dim">{w("label.sharedUntil", { day: until })}</span>
        {one && shared.formats.length > 0 && (
          <Menu
            label={w("button.saveAs")}
            side="right"
            items={shared.formats.map((format) => ({
              text: format.toUpperCase(),
              href: address("/documents/{id}/export", { id: one.id }, { format }),
              download: true,
            }))}
          >
            {w("button.saveAs")}
            <Icon name="down" />
          </Menu>
        )}
      </header>
      {one ? (
        <Playing key={one.id} id={one.id} revision={one.revision} />
      ) : (
        <div class="empty dim">{w("error.sharedGone")}</div>
      )}
      {shared.documents.length > 1 && (
        <nav class="shared-list row" aria-label={w("label.sharedClips")}>
          {shared.documents.map((each, index) => (
            <button
              key={each.id}
              type="button"
              class={index === at ? "button primary" : "button"}
              aria-current={index === at}
              onClick={() => setAt(index)}
            >
              {each.name}
            </button>
          ))}
        </nav>
      )}
    </main>
  );
}

async function exchanged(secret: string): Promise<Schemas["Shared"]> {
  const shared = await ask("post", "/shared", { body: { secret } });
  below("/api/v1/shared");
  return shared;
}

function Playing({ id, revision }: { id: string; revision: number }) {
  const motion = useAsync(() => motionOf(id, revision), [id, revision]);
  if (motion.error) return <Trouble error={motion.error} retry={motion.again} />;
  return motion.value ? <Moving motion={motion.value} /> : <div class="shared-stage" aria-busy="true" />;
}

function Moving({ motion }: { motion: Motion }) {
  const player = useMemo(() => new Player(motion.frames, motion.perSecond), [motion]);
  const actors = useMemo<Actor[]>(
    () => [
      {
        skeleton: motion.skeleton,
        positions: () => {
          motion.blocks.arrived.value;
          return motion.blocks.frame(player.frame.value);
        },
      },
    ],
    [motion],
  );
  useEffect(() => {
    const stop = effect(() => motion.blocks.want(player.frame.value, 1, motion.perSecond));
    player.play(1);
    return () => {
      stop();
      player.pause();
    };
  }, [player]);
  return (
    <div class="shared-stage">
      <MotionView actors={actors} label={motion.name} />
      <PlayBar player={player} />
    </div>
  );
}
