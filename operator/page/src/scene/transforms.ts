// Where chest and cameras are, and where the camera would be if the head looked elsewhere.
import { Matrix4, Quaternion, Vector3 } from "three";
import type { HeadPose } from "../state/app";
import type { OperatorStatus, TfMessage } from "../wire/messages";

// HRP-2's neck; what the camera's mount adds is found from where the camera is.
const kChestFromPan = new Matrix4().makeTranslation(0, 0, 0.33);
const kPanFromTilt = new Matrix4().makeTranslation(0, 0, 0.03);

export function chestFromHead({ pan, tilt }: HeadPose): Matrix4 {
  return kChestFromPan.clone()
    .multiply(new Matrix4().makeRotationZ(pan))
    .multiply(kPanFromTilt)
    .multiply(new Matrix4().makeRotationY(tilt));
}

type Transform = TfMessage["transforms"][number]["transform"];

function matrixOf({ translation: t, rotation: r }: Transform): Matrix4 {
  return new Matrix4().compose(new Vector3(t.x, t.y, t.z), new Quaternion(r.x, r.y, r.z, r.w), new Vector3(1, 1, 1));
}

export class Transforms {
  base = new Matrix4();
  chest = new Matrix4().makeTranslation(0, 0, 1);
  camera = new Matrix4();
  known = false;
  private headFromCamera = new Matrix4();

  take(message: TfMessage, status: OperatorStatus | undefined): void {
    for (const { child_frame_id, transform } of message.transforms) {
      if (child_frame_id === "base") this.base = matrixOf(transform);
      if (child_frame_id === "chest") this.chest = matrixOf(transform);
      if (child_frame_id === "camera_left") this.camera = matrixOf(transform);
    }
    this.known = true;
    // While the head turns, angles and camera may be of different moments.
    if (status?.at_rest) this.headFromCamera = this.head(status).invert().multiply(this.camera);
  }

  head(pose: HeadPose): Matrix4 {
    return this.chest.clone().multiply(chestFromHead(pose));
  }

  cameraAt(pose: HeadPose): Matrix4 {
    return this.head(pose).multiply(this.headFromCamera);
  }
}
