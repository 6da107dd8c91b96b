// WGSL of GLSL, for WebGPU: of the functions of look_up.glsl, or of a whole shader.
//
//   node wgsl.mjs NAGA_FOLDER FOLDER/look_up.glsl look_up.wgsl
//   node wgsl.mjs NAGA_FOLDER SHADER.comp|.frag|.vert SHADER.wgsl
//
// Needs glslangValidator (Debian: glslang-tools) and naga (workflow/install_from_npm.sh naga NAGA_FOLDER). look_up.wgsl has the grid at
// @group(0) @binding(0). Functions keep their names; what they are called with are pointers: nlgIrradiance(&position_m, &normal).
// Exit code 2 for wrong arguments, 3 for what is no such GLSL, with what glslangValidator or naga says of it.
import {spawnSync} from 'node:child_process';
import {mkdtempSync, readFileSync, rmSync, writeFileSync} from 'node:fs';
import {tmpdir} from 'node:os';
import path from 'node:path';
import {pathToFileURL} from 'node:url';

const refuse = (code, why) => {
  console.error(`wgsl.mjs: ${why}`);
  process.exit(code);
};

// A shader that calls every function that others call. In WGSL no two variables share a binding: words are numbers of fours.
const around = (include) => `#version 450
#extension GL_GOOGLE_include_directive : require
layout(local_size_x = 1) in;
layout(std430, binding = 0) readonly buffer NlgGrid { uvec4 fours[]; } nlg_grid;
layout(std430, binding = 1) buffer Caller { vec4 number; } caller;
uvec4 nlgHeader(int i) { return nlg_grid.fours[i]; }
uvec4 nlgFour(int i) { return nlg_grid.fours[i]; }
uint nlgWord(int i) { return nlg_grid.fours[i >> 2][i & 3]; }
#include "${include}"
void main() {
  vec3 place = caller.number.xyz;
  caller.number += vec4(nlgIrradiance(place, place).irradiance + nlgRadiance(place).sh[0], nlgSharesAt(place).share[0]);
}
`;

const [nagaFolder, source, out] = process.argv.slice(2);
if (!out) refuse(2, 'expected a folder with naga, a shader, and the file to write');
let naga;
try {
  naga = await import(pathToFileURL(path.resolve(nagaFolder, 'node_modules/naga-wasm/dist/node.js')));
} catch (error) {
  refuse(2, `no naga in ${nagaFolder}: ${error.message}; workflow/install_from_npm.sh naga ${nagaFolder} installs it`);
}

const isLibrary = path.extname(source) === '.glsl';
const folder = mkdtempSync(path.join(tmpdir(), 'wgsl-'));
process.on('exit', () => rmSync(folder, {recursive: true}));
const module = path.join(folder, 'module.spv');
let shader = source;
if (isLibrary) {
  shader = path.join(folder, 'around.comp');
  writeFileSync(shader, around(path.basename(source)));
}
const glslang = spawnSync('glslangValidator', ['--quiet', '-V', '--target-env', 'vulkan1.1', `-I${path.dirname(source)}`, '-o', module, shader]);
if (glslang.error) refuse(2, `glslangValidator: ${glslang.error.message} (Debian: glslang-tools)`);
if (glslang.status !== 0) refuse(3, `${source}: ${glslang.stdout}${glslang.stderr}`);
let text;
try {
  const parsed = naga.parseSpirv(readFileSync(module));
  text = naga.writeWgsl(parsed, naga.validate(parsed));
} catch (error) {
  refuse(3, `${source}: ${error.formatted ?? error.message}`);
}

// names without their types
text = text.replace(/\b(\w+?)_u0028_\w*/g, '$1');
// naga does not see which buffers a shader only reads
text = text.replace(/var<storage, read_write> (\w+)/g, (whole, name) => new RegExp(`^\\s*${name}\\b.* = `, 'm').test(text) ? whole : `var<storage, read> ${name}`);
if (isLibrary) {
  for (const part of [/struct Caller \{[^}]*\}\n\n/, /@group\(0\) @binding\(1\)\s+var<storage, read_write> caller: Caller;\n/, /fn main_1\(\) \{[^]*$/]) {
    if (!part.test(text)) refuse(3, `${source}: naga writes a shader in another way than version ${naga.nagaVersion} was known to`);
    text = text.replace(part, '');
  }
}
writeFileSync(out, text);
