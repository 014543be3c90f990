// Scales that people tell apart whatever colours they see: viridis for precision, cividis for height.
import { Color } from "three";

/** Steps of each scale at equal distances, from low to high. */
export const scales = {
  viridis: ["#440154", "#472d7b", "#3b528b", "#2c728e", "#21918c", "#28ae80", "#5ec962", "#addc30", "#fde725"],
  cividis: ["#00224e", "#123570", "#3b496c", "#575d6d", "#707173", "#8a8678", "#a59c74", "#c3b369", "#e1cc55"],
} as const;
export type ScaleName = keyof typeof scales;
export const kScaleSteps = 9;

/** For a shader: as the screen shows them, since these shaders write what they mean to show. */
export function scaleUniform(name: ScaleName): Color[] {
  return scales[name].map((step) => new Color().setStyle(step, "srgb-linear"));
}

export const scaleShader = /* glsl */ `
  vec3 scaleColor(float t, vec3 steps[${kScaleSteps}]) {
    float at = clamp(t, 0.0, 1.0) * float(${kScaleSteps - 1});
    vec3 color = steps[0];
    for (int i = 1; i < ${kScaleSteps}; ++i) color = mix(color, steps[i], clamp(at - float(i - 1), 0.0, 1.0));
    return color;
  }
`;

/** Standard deviations are shown between these, on a logarithmic scale [m]. */
export const kSigmaLow = 0.002;
export const kSigmaHigh = 0.1;
/** Heights [m]. */
export const kHeightLow = 0;
export const kHeightHigh = 2;

export const kPlanColor = "#2f8fdd";
export const kPreviewColor = "#e69f00";
export const kGoalColor = "#d55e00";
export const kUnseenColor = "#8f7ae6";
export const kLeftFoot = "#2f8fdd";
export const kRightFoot = "#1fa67a";
