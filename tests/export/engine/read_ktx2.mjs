// read_ktx2.mjs KTX_PARSE_FOLDER FILE TEXELS: what ktx-parse reads in a KTX2 file, as JSON; its texels go to a file.
import { readFileSync, writeFileSync } from 'node:fs';
import { pathToFileURL } from 'node:url';

const [folder, file, texels] = process.argv.slice(2);
const { read } = await import(pathToFileURL(`${folder}/node_modules/ktx-parse/dist/index.mjs`));
const container = read(readFileSync(file));
const descriptor = container.dataFormatDescriptor[0];
writeFileSync(texels, container.levels[0].levelData);
// texts with keys that it does not know come as bytes, their zero byte with them
const text = (value) => typeof value === 'string' ? value : new TextDecoder().decode(value).slice(0, -1);
console.log(JSON.stringify({
	format: container.vkFormat,
	size: [container.pixelWidth, container.pixelHeight, container.pixelDepth],
	samples: descriptor.samples.map((s) => [s.bitOffset, s.bitLength, s.channelType, s.sampleLower >>> 0, s.sampleUpper >>> 0]),
	texts: Object.fromEntries(Object.entries(container.keyValue).map(([key, value]) => [key, text(value)])),
}));
