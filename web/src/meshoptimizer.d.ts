// The package has no types for this one of its decoders.
declare module "meshoptimizer/meshopt_decoder_reference.js" {
  export const MeshoptDecoder: {
    decodeVertexBuffer(target: Uint8Array, count: number, stride: number, source: Uint8Array): void;
  };
}
