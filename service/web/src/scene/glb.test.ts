import { itemAt } from "../lists";
import { readFileSync } from "node:fs";
import { AnimationMixer, Vector3, type SkinnedMesh } from "three";
import { GLTFLoader } from "three/examples/jsm/loaders/GLTFLoader.js";
import { describe, expect, it, vi } from "vitest";

// The loader asks what browser it is in.
vi.hoisted(() => {
  (globalThis as { self?: object }).self ??= globalThis;
  (globalThis as { navigator?: object }).navigator ??= { userAgent: "" };
});
interface Case {
  title: string;
  path: string;
  times: number[];
  positions: number[][][];
  height: number;
}
// Clips that the tests in Python have written, and where their joints are.
const { MCML_GLB } = process.env;
const cases: Case[] = MCML_GLB ? JSON.parse(readFileSync(MCML_GLB, "utf8")) : [];

describe.skipIf(!cases.length)("a clip as glTF", () => {
  it.each(cases.map((one) => [one.title, one] as const))(
    "%s: has its joints where three.js plays them",
    async (_, one) => {
      const bytes = readFileSync(one.path);
      const model = await new GLTFLoader().parseAsync(
        bytes.buffer.slice(bytes.byteOffset, bytes.byteOffset + bytes.byteLength),
        "",
      );
      let body: SkinnedMesh | undefined;
      model.scene.traverse((item) => {
        if ((item as SkinnedMesh).isSkinnedMesh) body = item as SkinnedMesh;
      });
      const bones = body!.skeleton.bones;
      const mixer = new AnimationMixer(model.scene);
      expect(model.animations.length).toBe(1);
      mixer.clipAction(itemAt(model.animations, 0)).play();
      const place = new Vector3();
      let worst = 0;
      one.times.forEach((time, frame) => {
        mixer.setTime(time);
        model.scene.updateMatrixWorld(true);
        expect(bones.length).toBe(itemAt(one.positions, frame).length);
        bones.forEach((bone, joint) => {
          place.setFromMatrixPosition(bone.matrixWorld);
          worst = Math.max(worst, place.distanceTo(new Vector3(...itemAt(itemAt(one.positions, frame), joint))));
        });
      });
      expect(worst / one.height).toBeLessThan(1e-5);
    },
  );
});
