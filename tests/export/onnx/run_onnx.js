// Runs every model of a folder in onnxruntime and compares what comes out with what lies beside it (onnx_cases.cpp).
//   node run_onnx.js ONNXRUNTIME_FOLDER FOLDER FUNCTION_COUNT
// Exit code 1 when a value is off by more than 1e-4, of the largest of its row where that is above 1: sums that make up a row round by
// the size of their terms, and what comes of noise is large.
'use strict';
const fs = require('fs');
const path = require('path');

const [runtimeFolder, folder, countText] = process.argv.slice(2);
const onnxruntime = require(path.resolve(runtimeFolder, 'node_modules/onnxruntime-node'));
const count = Number(countText);
const tolerance = 1e-4;

function floats(stem, name) {
  const bytes = fs.readFileSync(path.join(folder, `${stem}.${name}.f32`));
  return new Float32Array(bytes.buffer, bytes.byteOffset, bytes.length / 4);
}

function largestDifference(a, b) {
  if (a.length !== b.length) throw new Error(`${a.length} numbers, expected ${b.length}`);
  let largest = 0;
  for (let row = 0; row < count; ++row) {
    const begin = row * b.length / count, end = begin + b.length / count;
    let unit = 1;
    for (let i = begin; i < end; ++i) unit = Math.max(unit, Math.abs(b[i]));
    for (let i = begin; i < end; ++i) {
      const difference = Math.abs(a[i] - b[i]) / unit;
      // a NaN is no agreement
      if (!(difference <= largest)) largest = difference;
    }
  }
  return largest;
}

async function main() {
  const models = fs.readdirSync(folder).filter((name) => name.endsWith('.onnx')).sort();
  if (models.length === 0) throw new Error('no model');
  let failures = 0;
  for (const model of models) {
    const stem = model.slice(0, -'.onnx'.length);
    const session = await onnxruntime.InferenceSession.create(path.join(folder, model));
    const inputs = {};
    for (const name of session.inputNames) {
      const values = floats(stem, name);
      inputs[name] = new onnxruntime.Tensor('float32', values, [count, values.length / count]);
    }
    const outputs = await session.run(inputs);
    for (const name of session.outputNames) {
      const difference = largestDifference(outputs[name].data, floats(stem, name));
      const holds = difference <= tolerance;
      failures += holds ? 0 : 1;
      console.log(`${model}: ${name} ${outputs[name].dims.join(' x ')}: largest difference ${difference.toExponential(2)}${holds ? '' : ' FAILED'}`);
    }
  }
  process.exitCode = failures > 0 ? 1 : 0;
}

main().catch((error) => {
  console.error(`run_onnx: ${error.message}`);
  process.exitCode = 1;
});
