// What lies on the floor is drawn over voxels of the floor, which may rise some centimetres above it.

/** For a material; the units are steps of the depth buffer, about 7 cm at a distance of 4 m. */
export const onFloor = { polygonOffset: true, polygonOffsetFactor: 0, polygonOffsetUnits: -4000 } as const;
