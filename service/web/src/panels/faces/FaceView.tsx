/** The face in the round: the one under the pointer, or the animation's. A mesh that is dropped on it follows the markers. */
import { effect, type ReadonlySignal } from "@preact/signals";
import { useEffect, useRef, useState } from "preact/hooks";
import { FaceStage, type Skin } from "../../scene/face";
import { note } from "../../state/session/notes";
import { param, setParams } from "../../state/session/route";
import { colour, look } from "../../state/session/settings";
import { f } from "./words";
import type { Space } from "./space";

export function FaceView({
  space,
  face,
  about,
}: {
  space: Space;
  face: ReadonlySignal<Float32Array | null>;
  about: ReadonlySignal<string>;
}) {
  const host = useRef<HTMLDivElement>(null);
  const stage = useRef<FaceStage | null>(null);
  const words = useRef<HTMLParagraphElement>(null);
  const file = useRef<HTMLInputElement>(null);
  const [hasMesh, setHasMesh] = useState(false);
  const skin = (param("skin") || "surface") as Skin;
  useEffect(() => {
    let made: FaceStage;
    try {
      made = new FaceStage(host.current!, space.neutral, space.facing, colour);
    } catch {
      return; // Without WebGL the small faces say the same.
    }
    stage.current = made;
    const stops = [
      effect(() => {
        look.value;
        made.recolour();
      }),
      effect(() => made.pose(face.value ?? space.neutral)),
      effect(() => {
        if (words.current) words.current.textContent = about.value;
      }),
    ];
    return () => {
      for (const stop of stops) stop();
      made.close();
      stage.current = null;
      setHasMesh(false);
    };
  }, [space]);
  useEffect(() => {
    stage.current?.wear(skin === "mesh" && !hasMesh ? "surface" : skin);
    stage.current?.pose(face.peek() ?? space.neutral);
  }, [skin, hasMesh, space]);
  const bindMesh = async (chosen: File) => {
    try {
      await stage.current?.bindMesh(chosen.name, await chosen.arrayBuffer());
      setHasMesh(true);
      setParams({ skin: "mesh" });
      stage.current?.pose(face.peek() ?? space.neutral);
    } catch {
      note(f("error.badMesh"), { bad: true });
    }
  };
  const wear = (next: Skin) => {
    if (next === "mesh" && !hasMesh) file.current?.click();
    else setParams({ skin: next === "surface" ? null : next });
  };
  return (
    <section
      class="faces-face"
      aria-label={f("label.face")}
      onDragOver={(event) => {
        if (event.dataTransfer?.types.includes("Files")) {
          event.preventDefault();
          event.stopPropagation();
        }
      }}
      onDrop={(event) => {
        const dropped = event.dataTransfer?.files[0];
        if (dropped) {
          event.preventDefault();
          event.stopPropagation();
          void bindMesh(dropped);
        }
      }}
    >
      <div class="stage" ref={host} role="img" aria-label={f("label.face")} />
      <div class="row faces-skin">
        <p class="dim grow cut" ref={words} />
        <div class="segments" role="group" aria-label={f("label.face")}>
          {(["markers", "surface", "mesh"] as const).map((one) => (
            <button
              key={one}
              type="button"
              aria-pressed={skin === one}
              title={one === "mesh" ? f("button.openMesh") : undefined}
              onClick={() => wear(one)}
            >
              {f(`label.${one}Skin`)}
            </button>
          ))}
        </div>
        <input
          ref={file}
          type="file"
          hidden
          accept=".obj,.glb,.gltf"
          aria-label={f("button.openMesh")}
          onChange={(event) => {
            const chosen = event.currentTarget.files?.[0];
            if (chosen) void bindMesh(chosen);
          }}
        />
      </div>
    </section>
  );
}
