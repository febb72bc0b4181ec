// The front's tets as instances of a small shape, whose vertices a shader places by the numbers of the tet's corners.

import * as THREE from "three";

import type { Topology } from "../protocol";

/** slots: three numbers for each vertex of the shape, for the shader to tell them apart. */
export function setTetInstances(
  mesh: THREE.Mesh<THREE.InstancedBufferGeometry>,
  { tets, tetLevel }: Topology,
  slots: Float32Array,
  index?: number[],
): void {
  // three cannot grow an attribute: a new geometry for a new front, of exactly its size.
  mesh.geometry.dispose();
  const geometry = new THREE.InstancedBufferGeometry();
  geometry.setAttribute("position", new THREE.BufferAttribute(slots, 3));
  if (index) geometry.setIndex(index);
  const integers = (values: ArrayLike<number>, size: number) => {
    const attribute = new THREE.InstancedBufferAttribute(new Int32Array(values), size);
    attribute.gpuType = THREE.IntType;
    return attribute;
  };
  geometry.setAttribute("corners", integers(tets, 4));
  geometry.setAttribute("level", integers(tetLevel, 1));
  geometry.instanceCount = tetLevel.length;
  mesh.geometry = geometry;
}
