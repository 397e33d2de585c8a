// A chapter in WebAssembly computes what its native program computes: node wasm_test.js PROGRAM SCRIPT.js
'use strict';
const {execFileSync} = require('child_process');

const path = require('path');

const [program, script] = process.argv.slice(2).map((file) => path.resolve(file));
const native = execFileSync(program, ['run', '--csv', '-'], {encoding: 'utf8', maxBuffer: 1 << 30});
const bytes = [];
require(script)({stdout: (byte) => byte === null || bytes.push(byte & 255), stderr: () => {}}).then((module) => {
  module.callMain(['run', '--csv', '-']);
  const ours = Buffer.from(bytes).toString('utf8');
  const [a, b] = [native, ours].map((text) => text.trim().split('\n').map((line) => line.split(',')));
  if (a.length < 2 || a.length !== b.length || String(a[0]) !== String(b[0]))
    throw new Error(`${a.length} and ${b.length} rows; first ${a[0]} and ${b[0]}`);
  let worst = 0, where = '';
  a[0].forEach((name, column) => {
    const largest = Math.max(1, ...a.slice(1).map((row) => Math.abs(row[column]) || 0));
    for (let i = 1; i < a.length; ++i) {
      if (a[i][column] === b[i][column]) continue;  // words too
      const error = Math.abs(a[i][column] - b[i][column]) / largest;
      if (!(error <= worst)) [worst, where] = [error, `${name} in row ${i}`];
    }
  });
  console.log(`${a.length - 1} rows, largest difference ${worst.toExponential(1)} of a column's largest value or 1${where && `: ${where}`}`);
  process.exit(worst <= 1e-9 ? 0 : 1);
}).catch((error) => {
  console.error(error);
  process.exit(1);
});
