/** The clip in three dimensions, with what the passport says of its units beside it. */
import { itemAt } from "../../../lists";
import { effect } from "@preact/signals";
import { useEffect, useRef, useState } from "preact/hooks";
import type { Clip } from "../../../state/clip/clip";
import { noteParams, param } from "../../../state/session/route";
import { colour, look } from "../../../state/session/settings";
import { Stage, type CameraView, type Pose } from "../../../scene/stage";
import type { Skin } from "../../../motion/body/skin";
import type { Character } from "../../../motion/loading/character";
import { Icon } from "../../../ui/icons";
import { Menu } from "../../../ui/Menu";
import { Trouble } from "../../../ui/Trouble";
import { rate, w } from "../../../words";
import { cameraView, frameAsked, shown } from "../actions";
import { filmOf, saveFilm, savePicture } from "./pictures";
import { BlendShapes } from "./BlendShapes";
import { bodiesBeside } from "./bodiesBeside";
import { Compared } from "./Compare";
import { floorOf, metresText, niceStep } from "./ground";
import { Reference } from "../media/InStep";
import { NothingSeen } from "./NothingSeen";
import { poseAt, positionsThen, skinOfBody, wearBody } from "./poses";
import { poseHandle } from "../posing/poseHandle";
import { restPose, type HeldHandle } from "./restPose";
import { forcesOf } from "./forces";
import { Toggles } from "./Toggles";
import { WhySticks } from "./WhySticks";

export function ViewerPane({ clip }: { clip: Clip }) {
  const host = useRef<HTMLDivElement>(null);
  const stage = useRef<Stage | null>(null);
  const handles = useRef<HeldHandle[]>([]);
  const words = useRef<HTMLParagraphElement>(null);
  const [noWebgl, setNoWebgl] = useState<unknown>(null);
  const [grid, setGrid] = useState(0.5);
  const { skeleton, player, detail } = clip;

  useEffect(() => {
    let made: Stage;
    try {
      made = new Stage(host.current!, colour);
    } catch (error) {
      setNoWebgl(error);
      return;
    }
    stage.current = made;
    const actor = made.add(skeleton);
    const forces = forcesOf(clip);
    let ghost = -1;
    let framed = false;
    let wore: Skin | null = null;
    const isPlaced = Boolean(param("cam"));
    const refit = (pose: Pose, body: Character | null) => {
      if (!pose.worn || !body?.skin || body.skin === wore) return;
      wore = body.skin;
      if (!isPlaced) made.frame(cameraView.peek());
    };
    let floorFrom = -1;
    const stops: (() => void)[] = [
      effect(() => {
        clip.blocks.arrived.value;
        clip.channels.arrived.value;
        const frame = player.frame.value;
        const old = clip.flipped.value ? clip.compared.value : null;
        old?.blocks.arrived.value;
        const show = shown.value;
        made.shown = show;
        made.selected = new Set(clip.selection.value.bones.map((name) => skeleton.byName.get(name)!));
        const body = wearBody(clip);
        made.dress(actor, skinOfBody(body));
        const pose: Pose = old
          ? { positions: positionsThen(old, frame, skeleton), before: [], trail: [] }
          : poseAt(clip, frame, show, [...made.selected], body);
        made.pose(actor, { ...pose, forces: show.forces && !old ? forces.at(frame) : null });
        const overview = clip.blocks.overview();
        const version = clip.blocks.arrived.peek();
        if (overview && floorFrom !== version && (floorFrom < 0 || overview.values.length)) {
          floorFrom = version;
          const floor = floorOf(skeleton, overview.values);
          const step = niceStep(skeleton.height);
          made.setFloor(floor, step);
          setGrid(step);
        }
        if (pose.positions && !framed) {
          // Markers may be unseen in the first frames: the camera looks at the first that are there.
          framed = made.frame(cameraView.peek()) || isPlaced;
          if (param("cam")) made.cameraText = param("cam");
          performance.mark("first-frame");
        }
        // A character of the library is another size than the joints of the clip.
        if (framed) refit(pose, body);
      }),
      effect(() => {
        const other = clip.compared.value;
        if (!other || clip.flipped.value) {
          if (ghost >= 0) made.pose(ghost, { positions: null, before: [], trail: [] });
          return;
        }
        if (ghost < 0) ghost = made.add(skeleton, { dim: true });
        other.blocks.arrived.value;
        made.pose(ghost, { positions: positionsThen(other, player.frame.value, skeleton), before: [], trail: [] });
      }),
      effect(() => {
        look.value;
        made.recolour();
      }),
      effect(() => {
        const view = cameraView.value;
        if (framed) made.frame(view);
      }),
      effect(() => {
        if (frameAsked.value && framed) made.frame(cameraView.peek(), [...made.selected]);
      }),
      effect(() => {
        if (!player.playing.value && words.current)
          words.current.textContent = w("label.viewerWords", {
            name: detail.name,
            frame: player.frame.value + 1,
            n: clip.frames,
          });
      }),
    ];
    handles.current = [restPose(clip, made), poseHandle(clip, made)];
    stops.push(bodiesBeside(clip, made, actor));
    made.onCamera = () => framed && noteParams({ cam: made.cameraText });
    return () => {
      for (const stop of stops) stop();
      forces.close();
      for (const handle of handles.current.splice(0)) handle.stop();
      made.close();
      stage.current = null;
    };
  }, [clip]);

  const pulled = useRef<HeldHandle | null>(null);
  const press = useRef<[number, number] | null>(null);
  const place = (event: PointerEvent): [number, number] => {
    const box = host.current!.getBoundingClientRect();
    return [event.clientX - box.left, event.clientY - box.top];
  };
  const passport = (
    <div class="passport">
      <span class={detail.unit ? "" : "guess"} title={w("label.unit")}>
        {skeleton.view.likely_unit ?? w("label.unitUnknown")}
      </span>
      <span class={detail.seconds_per_frame ? "" : "guess"} title={w("label.rateWord")}>
        {rate(detail.seconds_per_frame)}
      </span>
      <span class={detail.up ? "" : "guess"} title={w("label.up")}>
        {skeleton.view.likely_up}
      </span>
    </div>
  );
  return (
    <div class="viewer">
      <div class="viewer-tools row">
        <Menu
          label={w("label.view")}
          className="button quiet dense"
          items={(["persp", "front", "side", "top"] as CameraView[]).map((one) => ({
            text: w(`label.${one}`),
            checked: cameraView.value === one,
            run: () => {
              cameraView.value = one;
              frameAsked.value++;
            },
          }))}
        >
          {w(`label.${cameraView.value}`)}
          <Icon name="down" />
        </Menu>
        <Toggles clip={clip} />
        <span class="grow" />
        {passport}
        <Menu
          label={w("button.picture")}
          className="button quiet icon dense"
          side="right"
          items={[
            {
              text: w("button.picture"),
              detail: "PNG",
              run: () => stage.current && void savePicture(stage.current, clip),
            },
            {
              text: w("button.film"),
              detail: filmOf().name,
              run: () => stage.current && void saveFilm(stage.current, clip),
            },
          ]}
        >
          <Icon name="more" />
        </Menu>
      </div>
      <div
        ref={host}
        class="stage"
        role="img"
        aria-label={w("label.viewerWords", { name: detail.name, frame: player.frame.peek() + 1, n: clip.frames })}
        tabIndex={0}
        onPointerDownCapture={(event) => {
          press.current = place(event);
          const at = press.current;
          pulled.current = (!event.button && handles.current.find((handle) => handle.grab(...at))) || null;
          if (pulled.current) event.currentTarget.setPointerCapture(event.pointerId);
        }}
        onPointerMove={(event) => {
          if (pulled.current) {
            pulled.current.pull(...place(event));
            return;
          }
          const made = stage.current;
          if (!made || event.buttons) return;
          const near = made.pick(...place(event));
          const found = near?.actor === 0 ? near.point : -1;
          if (found !== made.hovered) {
            made.hovered = found;
            made.ask();
          }
        }}
        onPointerCancel={() => {
          pulled.current?.drop();
          pulled.current = null;
        }}
        onPointerUp={(event) => {
          if (pulled.current) {
            pulled.current.drop();
            pulled.current = null;
            return;
          }
          const [x, y] = place(event);
          const moved = press.current ? Math.hypot(x - press.current[0], y - press.current[1]) : 9;
          if (moved > 4 || event.button) return;
          const found = stage.current?.pick(x, y);
          const name = found?.actor === 0 && itemAt(skeleton.view.bones, found.point).name;
          if (!name) {
            clip.select([]);
            return;
          }
          const before = clip.selection.peek().bones;
          if (event.ctrlKey || event.shiftKey)
            clip.select(before.includes(name) ? before.filter((one) => one !== name) : [...before, name]);
          else clip.select([name]);
        }}
      >
        {noWebgl !== null && <Trouble error={noWebgl} />}
        {clip.frames === 0 && <div class="empty">{w("help.noFrames")}</div>}
        <span class="grid-label dim">
          {w("label.gridOf", { size: metresText(grid) })}
          {!skeleton.unitKnown && <span class="guess" />}
        </span>
        <WhySticks clip={clip} />
        <NothingSeen clip={clip} />
      </div>
      {detail.media && <Reference clip={clip} media={detail.media} />}
      {clip.blocks.trouble.value !== null && (
        <Trouble error={clip.blocks.trouble.value} retry={() => clip.blocks.want(player.frame.peek())} />
      )}
      <BlendShapes clip={clip} />
      <Compared clip={clip} />
      <p ref={words} class="unseen" aria-live="polite" />
    </div>
  );
}
