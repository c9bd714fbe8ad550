#!/usr/bin/env node
// gltf_validate.js FILE [SOURCE]: what the Khronos validator finds in FILE that it does not find in
// SOURCE (or at all, with no SOURCE), one issue kind a line.
// Exit: 0 nothing · 1 something · 2 a file cannot be read · 3 the validator is not installed.
'use strict';
const fs = require('fs');
const path = require('path');

let validator;
try {
  validator = require('gltf-validator');
} catch {
  console.error('gltf_validate: gltf-validator is not installed (make setup)');
  process.exit(3);
}

const severities = ['error', 'warning', 'info', 'hint'];

// Issue kinds with how often each occurs and where it first does.
async function issues(file) {
  const folder = path.dirname(file);
  const report = await validator.validateBytes(new Uint8Array(fs.readFileSync(file)), {
    uri: path.basename(file),
    maxIssues: 0,
    externalResourceFunction: async (uri) =>
      new Uint8Array(fs.readFileSync(path.join(folder, decodeURIComponent(uri)))),
  });
  const found = new Map();
  for (const message of report.issues.messages) {
    const kind = `${severities[message.severity]} ${message.code}`;
    const entry = found.get(kind) || { count: 0, first: `${message.message} ${message.pointer || ''}` };
    entry.count += 1;
    found.set(kind, entry);
  }
  return found;
}

async function main([file, source]) {
  if (!file) {
    console.error('usage: gltf_validate.js FILE [SOURCE]');
    return 2;
  }
  const [ours, theirs] = [await issues(file), source ? await issues(source) : new Map()];
  let worse = 0;
  for (const [kind, { count, first }] of ours) {
    const before = theirs.has(kind) ? theirs.get(kind).count : 0;
    if (count > before) {
      worse += 1;
      console.log(`${file}: ${kind}: ${count}, source ${before}: ${first.trim()}`);
    }
  }
  return worse ? 1 : 0;
}

main(process.argv.slice(2)).then(
  (code) => process.exit(code),
  (error) => {
    console.error(`gltf_validate: ${error.message || error}`);
    process.exit(2);
  });
