// Reads KTX2 files with ktx-parse. The standard input holds files one after the other, each with its length
// in front (32 bits, little endian). Prints one line of JSON for each: what the container says.
import { readFileSync } from "node:fs";
import { read } from "ktx-parse";

// ktx-parse gives the format's own keys as text, and others as bytes that end in NUL.
function text(value) {
  return typeof value === "string" ? value : new TextDecoder().decode(value).replace(/\0$/, "");
}

const input = readFileSync(0);
for (let at = 0; at < input.length; ) {
  const length = input.readUInt32LE(at);
  const file = read(new Uint8Array(input.subarray(at + 4, at + 4 + length)));
  at += 4 + length;
  const [descriptor] = file.dataFormatDescriptor;
  console.log(
    JSON.stringify({
      format: file.vkFormat,
      type_size: file.typeSize,
      size: [file.pixelWidth, file.pixelHeight],
      depth_layers_faces: [file.pixelDepth, file.layerCount, file.faceCount],
      supercompression: file.supercompressionScheme,
      levels: file.levels.map((level) => [level.levelData.length, level.uncompressedByteLength]),
      keys: Object.fromEntries(Object.entries(file.keyValue).map(([key, value]) => [key, text(value)])),
      model: descriptor.colorModel,
      primaries: descriptor.colorPrimaries,
      transfer: descriptor.transferFunction,
      block: descriptor.texelBlockDimension,
      plane_bytes: descriptor.bytesPlane[0],
      samples: descriptor.samples.map((sample) => [sample.bitOffset, sample.bitLength]),
    }),
  );
}
