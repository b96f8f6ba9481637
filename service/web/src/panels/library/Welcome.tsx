/** The first start: one loop that plays large, and three ways to begin. Gone for good when it is closed. */
import { useEffect, useMemo } from "preact/hooks";
import { get } from "../../api/client";
import { motionOf } from "../../motion/loading/source";
import { Player } from "../../state/clip/player";
import { reducedMotion } from "../../state/session/settings";
import { chooseFiles } from "../../state/importing/uploads";
import { welcomed } from "../../state/session/welcome";
import { Icon, type IconName } from "../../ui/icons";
import { MotionView, type Actor } from "../../ui/playing/MotionView";
import { useAsync } from "../../ui/useAsync";
import { w, type Word } from "../../words";

const ASKED = "//frame[motion_name='wave']";

export function Welcome({ clips }: { /** In the whole library. */ clips: number }) {
  const demo = useAsync(
    (signal) => get("/documents", { query: { project: "demo", limit: 100, sort: "name" }, signal }),
    [],
  );
  const called = (beginning: string) => demo.value?.items.find((one) => one.name.startsWith(beginning));
  const [dance, walk] = [called("dance"), called("walk")];
  const make =
    walk && dance
      ? `/compose?s=${walk.id}:1-150,${dance.id}&name=${encodeURIComponent(w("label.welcomeMake"))}`
      : "/compose";
  return (
    <section class="welcome" aria-label={w("label.welcome")}>
      <div class="welcome-figure">{dance && <Loop id={dance.id} />}</div>
      <div class="welcome-words">
        <h2>{w("label.welcome")}</h2>
        <p>{w("help.welcomeHelp", { n: clips })}</p>
        <ul>
          <li>
            <button type="button" class="offer" onClick={() => chooseFiles()}>
              <Offer icon="upload" word="button.welcomeDrop" help="help.welcomeDropHelp" />
            </button>
          </li>
          <li>
            <a class="offer" href={`/xpath?q=${encodeURIComponent(ASKED)}`}>
              <Offer icon="xpath" word="label.welcomeAsk" help="help.welcomeAskHelp" />
            </a>
          </li>
          <li>
            <a class="offer" href={demo.busy ? undefined : make}>
              <Offer icon="compose" word="label.welcomeMake" help="help.welcomeMakeHelp" />
            </a>
          </li>
        </ul>
      </div>
      <button
        type="button"
        class="button quiet icon welcome-close"
        aria-label={w("button.welcomeGone")}
        title={w("button.welcomeGone")}
        onClick={() => (welcomed.value = true)}
      >
        <Icon name="close" />
      </button>
    </section>
  );
}

const Offer = ({ icon, word, help }: { icon: IconName; word: Word; help: Word }) => (
  <>
    <Icon name={icon} />
    <span class="grow">
      <strong>{w(word)}</strong>
      <span class="dim block">{w(help)}</span>
    </span>
  </>
);

function Loop({ id }: { id: string }) {
  const motion = useAsync(() => motionOf(id), [id]).value;
  const player = useMemo(() => (motion ? new Player(motion.frames, motion.perSecond) : null), [motion]);
  useEffect(() => {
    if (!motion || !player) return;
    const stop = player.frame.subscribe((frame) => motion.blocks.want(frame, 1, motion.perSecond));
    if (!reducedMotion.matches) player.play(1);
    return () => {
      stop();
      player.pause();
    };
  }, [player]);
  const actors = useMemo<Actor[]>(
    () =>
      motion && player
        ? [
            {
              skeleton: motion.skeleton,
              inPlace: true,
              positions: () => {
                motion.blocks.arrived.value;
                return motion.blocks.frame(player.frame.value);
              },
            },
          ]
        : [],
    [motion, player],
  );
  return actors.length ? <MotionView actors={actors} label={w("label.welcomePlays", { name: motion!.name })} /> : null;
}
