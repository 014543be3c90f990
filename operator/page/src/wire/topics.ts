// Which topic carries which message, as operator/channels.h lists them.
import type { Message } from "./cdr";
import { compressedImage, markerArray, occupancyGrid, operatorStatus, path, pointCloud2, tfMessage, voxels } from "./messages";

export const topics = {
  status: { topic: "/headway/status", codec: operatorStatus },
  picture: { topic: "/camera/left", codec: compressedImage },
  points: { topic: "/points", codec: pointCloud2 },
  map: { topic: "/map", codec: occupancyGrid },
  plan: { topic: "/plan", codec: path },
  footsteps: { topic: "/footsteps", codec: markerArray },
  tf: { topic: "/tf", codec: tfMessage },
  field: { topic: "/field", codec: markerArray },
  preview: { topic: "/preview", codec: path },
  voxels: { topic: "/voxels", codec: voxels },
  planBody: { topic: "/plan/body", codec: occupancyGrid },
  previewBody: { topic: "/preview/body", codec: occupancyGrid },
} as const;

export type TopicName = keyof typeof topics;
export type TopicMessage<N extends TopicName> = Message<(typeof topics)[N]["codec"]>;
export const topicNames = Object.keys(topics) as TopicName[];
