// The newest view's points, coloured by how precisely each is known or as the camera saw them.
import { BufferAttribute, BufferGeometry, DynamicDrawUsage, Points, ShaderMaterial } from "three";
import type { PointCloud2 } from "../wire/messages";
import { kScaleSteps, kSigmaHigh, kSigmaLow, scaleShader, scaleUniform } from "./colours";

const kMost = 20000;

function material(): ShaderMaterial {
  return new ShaderMaterial({
    uniforms: { steps: { value: scaleUniform("viridis") }, picture: { value: 0 }, scale: { value: 600 } },
    vertexShader: /* glsl */ `
      uniform vec3 steps[${kScaleSteps}];
      uniform float picture, scale;
      attribute float sigma;
      attribute vec3 seen;
      varying vec3 shown;
      ${scaleShader}
      void main() {
        float t = log(max(sigma, 1e-5) / ${kSigmaLow}) / log(${(kSigmaHigh / kSigmaLow).toFixed(1)});
        shown = mix(scaleColor(t, steps), seen, picture);
        vec4 at = modelViewMatrix * vec4(position, 1.0);
        gl_Position = projectionMatrix * at;
        gl_PointSize = clamp(0.018 * scale / max(0.1, -at.z), 2.0, 9.0);
      }`,
    fragmentShader: /* glsl */ `
      varying vec3 shown;
      void main() { gl_FragColor = vec4(shown, 1.0); }`,
  });
}

/** Where each of a point's values lies in its record [bytes]. */
function offsets(message: PointCloud2): Record<string, number> {
  return Object.fromEntries(message.fields.map((field) => [field.name, field.offset]));
}

export class Cloud {
  count = 0;
  readonly position = new Float32Array(3 * kMost);
  readonly sigma = new Float32Array(kMost);
  private readonly seen = new Uint8Array(3 * kMost);
  private readonly geometry = new BufferGeometry();
  private readonly shader = material();
  readonly object = new Points(this.geometry, this.shader);

  constructor() {
    const attribute = (name: string, array: Float32Array | Uint8Array, size: number, normalised = false) =>
      this.geometry.setAttribute(name, new BufferAttribute(array, size, normalised).setUsage(DynamicDrawUsage));
    attribute("position", this.position, 3);
    attribute("sigma", this.sigma, 1);
    attribute("seen", this.seen, 3, true);
    this.geometry.setDrawRange(0, 0);
    this.object.frustumCulled = false;
  }

  set asPictured(on: boolean) {
    this.shader.uniforms["picture"]!.value = on ? 1 : 0;
  }

  /** Pixels per metre at one metre. */
  set pixels(height: number) {
    this.shader.uniforms["scale"]!.value = height;
  }

  take(message: PointCloud2): void {
    const { data, point_step } = message;
    const view = new DataView(data.buffer, data.byteOffset, data.byteLength);
    const at = offsets(message);
    this.count = Math.min(kMost, message.width * message.height, Math.floor(data.byteLength / point_step));
    for (let i = 0; i < this.count; ++i) this.read(view, i, i * point_step, at);
    for (const name of ["position", "sigma", "seen"]) this.geometry.getAttribute(name).needsUpdate = true;
    this.geometry.setDrawRange(0, this.count);
  }

  private read(view: DataView, i: number, from: number, at: Record<string, number>): void {
    const value = (name: string) => view.getFloat32(from + (at[name] ?? 0), true);
    this.position[3 * i] = value("x");
    this.position[3 * i + 1] = value("y");
    this.position[3 * i + 2] = value("z");
    this.sigma[i] = value("sigma");
    const rgb = view.getUint32(from + (at["rgb"] ?? 0), true);
    this.seen[3 * i] = rgb >> 16;
    this.seen[3 * i + 1] = rgb >> 8;
    this.seen[3 * i + 2] = rgb;
  }
}
