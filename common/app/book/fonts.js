// The part of a TrueType font that the pictures use: the glyphs of the ranges that fonts.cpp names, with the
// tables that stb_truetype reads. The whole fonts have 1.4 MB, and each chapter of the book would carry them.
//
//   node fonts.js FONTS.CPP FONT.ttf OUT.ttf
'use strict';
const fs = require('fs');

const [ranges, input, output] = process.argv.slice(2);
const font = fs.readFileSync(input);
const table = {};
for (let i = 0, at = 12; i < font.readUInt16BE(4); ++i, at += 16)
  table[font.toString('latin1', at, at + 4)] = font.subarray(font.readUInt32BE(at + 8), font.readUInt32BE(at + 8) + font.readUInt32BE(at + 12));

// cmap: of the subtable of format 4, which has all characters below 0x10000.
const {cmap} = table;
let map;
for (let i = 0; i < cmap.readUInt16BE(2); ++i) {
  const at = cmap.readUInt32BE(4 + 8 * i + 4);
  if (cmap.readUInt16BE(at) === 4) map = cmap.subarray(at);
}
function glyphOf(character) {
  const twice = map.readUInt16BE(6);
  for (let at = 14; at < 14 + twice; at += 2) {
    const start = map.readUInt16BE(at + twice + 2), delta = map.readUInt16BE(at + 2 * twice + 2), offset = map.readUInt16BE(at + 3 * twice + 2);
    if (character > map.readUInt16BE(at)) continue;
    if (character < start) return 0;
    const glyph = offset ? map.readUInt16BE(at + 3 * twice + 2 + offset + 2 * (character - start)) : character;
    return glyph && (glyph + delta) & 0xffff;
  }
  return 0;
}

const long = table.head.readInt16BE(50) === 1, metrics = table.hhea.readUInt16BE(34);
const placeOf = (i) => long ? table.loca.readUInt32BE(4 * i) : 2 * table.loca.readUInt16BE(2 * i);
const kept = [0], number = {0: 0};  // the old glyphs, and their new numbers
function keep(glyph) {
  if (number[glyph] === undefined) number[glyph] = kept.push(glyph) - 1;
  return number[glyph];
}
const characters = [];
for (const [, first, last] of fs.readFileSync(ranges, 'utf8').matchAll(/^\s+(0x[0-9a-f]+), (0x[0-9a-f]+),/gm))
  for (let character = Number(first); character <= Number(last); ++character)
    if (glyphOf(character)) characters.push([character, keep(glyphOf(character))]);

const outlines = [], places = [];
let size = 0;
for (let i = 0; i < kept.length; ++i) {  // grows by the parts of what is composed
  const outline = Buffer.from(table.glyf.subarray(placeOf(kept[i]), placeOf(kept[i] + 1)));
  if (outline.length && outline.readInt16BE(0) < 0)
    for (let at = 10, flags = 0x20; flags & 0x20;) {
      flags = outline.readUInt16BE(at);
      outline.writeUInt16BE(keep(outline.readUInt16BE(at + 2)), at + 2);
      at += 4 + (flags & 1 ? 4 : 2) + (flags & 8 ? 2 : flags & 0x40 ? 4 : flags & 0x80 ? 8 : 0);
    }
  places.push(size);
  outlines.push(outline, Buffer.alloc(-outline.length & 3));
  size += outline.length + (-outline.length & 3);
}

const numbers = (bytes, values) => {
  const buffer = Buffer.alloc(bytes * values.length);
  values.forEach((value, i) => buffer.writeUIntBE(value, bytes * i, bytes));
  return buffer;
};
const patched = (name, at, value) => {
  const buffer = Buffer.from(table[name]);
  buffer.writeUInt16BE(value, at);
  return buffer;
};
const groups = characters.flatMap(([character, glyph]) => [character, character, glyph]);
const tables = {
  cmap: Buffer.concat([numbers(2, [0, 1, 3, 10]), numbers(4, [12]), numbers(2, [12, 0]),
    numbers(4, [16 + 4 * groups.length, 0, characters.length, ...groups])]),
  glyf: Buffer.concat(outlines),
  head: patched('head', 50, 1),
  hhea: patched('hhea', 34, kept.length),
  hmtx: Buffer.concat(kept.map((glyph) => {
    const last = 4 * (metrics - 1);
    return glyph < metrics ? table.hmtx.subarray(4 * glyph, 4 * glyph + 4)
      : Buffer.concat([table.hmtx.subarray(last, last + 2), table.hmtx.subarray(last + 4 + 2 * (glyph - metrics), last + 6 + 2 * (glyph - metrics))]);
  })),
  loca: numbers(4, [...places, size]),
  maxp: patched('maxp', 4, kept.length),
};
const names = Object.keys(tables);
let at = 12 + 16 * names.length;
const directory = [numbers(4, [0x10000]), numbers(2, [names.length, 0, 0, 0])], bodies = [];
for (const name of names) {
  directory.push(Buffer.from(name, 'latin1'), numbers(4, [0, at, tables[name].length]));
  bodies.push(tables[name], Buffer.alloc(-tables[name].length & 3));
  at += tables[name].length + (-tables[name].length & 3);
}
fs.writeFileSync(output, Buffer.concat([...directory, ...bodies]));
