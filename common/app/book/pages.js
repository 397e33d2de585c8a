// The pages of the book: every lesson and document as HTML, with its formulas set, its code coloured, its
// pictures as WebP, and a page for each source file that a document links to.
//
//   node pages.js SOURCE OUT [SCENES]     what is said of a fault names it; the exit status is then 1
//
// SCENES is the folder of the chapters in WebAssembly; without it a scene stays a picture.
// A page stands where its document stands, README.md as index.html, so that the links of the documents hold.
'use strict';
const fs = require('fs');
const path = require('path');
const {execFileSync} = require('child_process');
process.env.HLJS_HIDE_UPGRADE_WARNING = 'yes';  // Debian's says at each start that it is old
const hljs = require('highlight.js');
const katex = require('katex');
const markdown = require('markdown-it');

const [source, out, scenes] = process.argv.slice(2, 5).map((folder) => path.resolve(folder));
const read = (file) => fs.readFileSync(path.join(source, file), 'utf8');
const list = (folder) => fs.readdirSync(path.join(source, folder)).sort();
const exists = (file) => fs.existsSync(path.join(source, file));
const escape = (text) => markdown().utils.escapeHtml(text);
const faults = [];
const written = {};  // bytes by kind

function write(file, content) {
  const target = path.join(out, file), kind = path.extname(file).slice(1);
  fs.mkdirSync(path.dirname(target), {recursive: true});
  fs.writeFileSync(target, content);
  written[kind] = (written[kind] || 0) + fs.statSync(target).size;
}

// ---------------------------------------------------------------------------------------------------------
// what there is

// The documents in the order in which docs/README.md names them, then those that it does not name.
const named = [...read('docs/README.md').matchAll(/^\| \[[^\]]*\]\(([\w.]+)\)/gm)].map(([, name]) => name);
const documents = ['README.md', ...list('chapters').map((name) => `chapters/${name}/README.md`).filter(exists),
  ...new Set(['README.md', ...named, ...list('docs').filter((name) => name.endsWith('.md'))].map((name) => `docs/${name}`))];
const titleOf = (file) => plain(/^# (.*)$/m.exec(read(file))[1]);
const plain = (text) => text.replace(/[`*$]/g, '');
const pageOf = (file) => file.replace(/README\.md$/, 'index.html').replace(/\.md$/, '.html');
const from = (page, target) => path.relative(path.dirname(page), target) || path.basename(target);

// Sources that some page links to, each with a page of its own; folders, with a page that lists them.
const sources = new Set();
function pageOfSource(file) {
  const folder = fs.statSync(path.join(source, file)).isDirectory();
  sources.add(file);
  return folder ? `${file}/index.html` : `${file}.html`;
}

// ---------------------------------------------------------------------------------------------------------
// Markdown, as GitHub reads it

const md = markdown({html: true, highlight: (text, language) => colour(text, language)});

function colour(text, language) {
  const known = {sh: 'bash', json: 'json', yml: 'yaml'}[language] || language;
  return hljs.getLanguage(known) ? hljs.highlight(known, text).value : escape(text);
}

function formula(tex, displayMode, env) {
  env.formulas += 1;
  try {
    return katex.renderToString(tex, {displayMode, throwOnError: true, strict: 'error', output: 'htmlAndMathml'});
  } catch (error) {
    faults.push(`${env.file}: ${error.message}`);
    return escape(tex);
  }
}

md.inline.ruler.before('escape', 'formula', (state, silent) => {
  const end = state.src.indexOf('$', state.pos + 1), tex = state.src.slice(state.pos + 1, end);
  if (state.src[state.pos] !== '$' || end < 0 || tex === '' || tex !== tex.trim()) return false;
  if (!silent) state.push('formula', '', 0).content = tex;
  state.pos = end + 1;
  return true;
});
md.renderer.rules.formula = (tokens, i, options, env) => formula(tokens[i].content, false, env);

const fence = md.renderer.rules.fence;
md.renderer.rules.fence = (tokens, i, options, env, self) =>
  tokens[i].info === 'math' ? `<div class="formula" tabindex="0">${formula(tokens[i].content, true, env)}</div>\n`
    : fence(tokens, i, options, env, self).replace('<pre>', '<pre tabindex="0">');

// A line that stands indented is a command; one of a chapter's program is a link to that state of its scene.
md.renderer.rules.code_block = (tokens, i, options, env) =>
  `<pre tabindex="0"><code>${tokens[i].content.trimEnd().split('\n')
    .map((line) => live(line, env, escape(line))).join('\n')}\n</code></pre>\n`;
md.renderer.rules.code_inline = (tokens, i, options, env) =>
  live(tokens[i].content, env, `<code>${escape(tokens[i].content)}</code>`);
// <!-- live: OPTIONS --> names a state that the text before it tells of.
md.renderer.rules.html_block = (tokens, i, options, env) => {
  const asked = /^<!-- live: (.*) -->/.exec(tokens[i].content);
  if (asked && !env.chapter) return '';
  if (asked) return `<p class="see">${live(`live ${asked[1]}`, env, 'See it fail in the live scene') }</p>\n`;
  return tokens[i].content.replace(/<!--[^]*?-->\s*/g, '').replace(/<img src="([^"]*)"([^>]*)>/g,
    (_, file, rest) => image(file, rest, env));
};

/// `html`, as a link to the scene with the options of `command`, if it is a call of this chapter's program
/// with values for all of them (`--path NAME` has none).
function live(command, env, html) {
  const call = /^(?:build\/bin\/(\w+) |\.\/tutorial )?(run|live|snapshot)(?: (\d+))?((?: --[\w-]+ (?![A-Z]+\b)[-+.\w]+)+)(?: +#.*)?$/.exec(command);
  if (!call || !env.chapter || call[1] && call[1] !== env.chapter || call[3] && +call[3] !== parseInt(env.chapter, 10))
    return html;
  const query = new URLSearchParams();
  for (const [, name, value] of call[4].matchAll(/--([\w-]+) ([-+.\w]+)/g)) query.set(name, value);
  for (const name of ['csv', 'every', 'out', 'size', 'scale', 'theme', 'at', 'frames', 'fps', 'sheet']) query.delete(name);
  if (query.has('tolerance') || !query.toString()) return html;  // the window has no such steps
  if (call[2] !== 'live' && !['stabilization', 'ks', 'kd'].some((name) => query.has(name)))
    query.set('stabilization', 'none');  // as the program has it, but not the window
  return `<a class="live" href="?${escape(query.toString())}#scene">${html}</a>`;
}

const anchor = (heading) => heading.toLowerCase().replace(/[^\p{L}\p{N}\p{M}_ -]/gu, '').replace(/ /g, '-');

md.core.ruler.push('book', (state) => {
  const tokens = state.tokens, env = state.env, seen = {};
  for (let i = 0; i < tokens.length; ++i) {
    if (tokens[i].type === 'heading_open') {
      const text = plain(tokens[i + 1].children.map((child) => child.content).join(''));
      let name = anchor(text);
      if (seen[name]) name += `-${seen[name]++}`; else seen[name] = 1;
      tokens[i].attrSet('id', name);
      if (tokens[i].tag === 'h2') env.headings.push([name, text]);
    }
    // A picture alone in its paragraph is a figure, and the slanted paragraph after it its caption.
    const only = tokens[i + 1] && tokens[i + 1].children;
    if (tokens[i].type === 'paragraph_open' && only.length === 1 && only[0].type === 'image') {
      tokens[i].tag = tokens[i + 2].tag = 'figure';
      let next = i + 3;
      while (tokens[next] && tokens[next].type === 'html_block' && /^<!-- (figures|given)/.test(tokens[next].content)) next += 1;
      const words = tokens[next] && tokens[next].type === 'paragraph_open' && tokens[next + 1].children;
      if (!words || words[0].type !== 'em_open' || words[words.length - 1].type !== 'em_close') continue;
      tokens[next].tag = tokens[next + 2].tag = 'figcaption';
      tokens[next + 1].children = words.slice(1, -1);
      tokens.splice(next + 3, 0, tokens[i + 2]);
      tokens.splice(i + 2, next - i - 2);
    }
  }
});

md.renderer.rules.image = (tokens, i, options, env) =>
  image(tokens[i].attrGet('src'), ` alt="${escape(tokens[i].content)}"`, env);

const pictures = new Set();
function image(target, rest, env) {
  const file = path.join(path.dirname(env.file), target);
  if (!/ alt="[^"]+"/.test(rest)) faults.push(`${env.file}: ${target} has no words in place of the picture`);
  if (!exists(file)) return faults.push(`${env.file}: no file ${target}`) && '';
  pictures.add(file);
  const head = fs.readFileSync(path.join(source, file)).subarray(16, 24);
  const lazy = env.pictures++ ? ' loading="lazy"' : '';
  return `<img src="${target.replace(/png$/, 'webp')}" width="${head.readUInt32BE(0) / 2}" height="${
    head.readUInt32BE(4) / 2}"${rest.replace(/ width="49%"/, ' class="half"')}${lazy}>`;
}

const linkOpen = (tokens, i, options, env, self) => {
  const [target, heading] = tokens[i].attrGet('href').split('#');
  if (!/^[a-z]+:/.test(target) && target !== '') {
    const file = path.join(path.dirname(env.file), decodeURI(target)).replace(/\/$/, '');
    if (!exists(file)) faults.push(`${env.file}: no file ${target}`);
    else {
      const page = documents.includes(file) ? pageOf(file) : file.endsWith('.png') ? file : pageOfSource(file);
      tokens[i].attrSet('href', from(env.page, page) + (heading ? `#${heading}` : ''));
    }
  }
  return self.renderToken(tokens, i, options);
};
md.renderer.rules.link_open = linkOpen;

// ---------------------------------------------------------------------------------------------------------
// a page

function contents(page, headings) {
  const entry = (file) => {
    const own = pageOf(file) === page;
    const inside = own && headings.length
      ? `<ol>${headings.map(([name, text]) => `<li><a href="#${name}">${escape(text)}</a></li>`).join('')}</ol>` : '';
    const title = file === 'README.md' ? 'Start' : titleOf(file);
    return `<li><a href="${from(page, pageOf(file))}"${own ? ' aria-current="page"' : ''}>${escape(title)}</a>${inside}</li>`;
  };
  const some = (folder) => documents.filter((file) => file.startsWith(folder)).map(entry).join('\n');
  return `<ul>${some('README.md')}</ul>\n<h2>Lessons</h2>\n<ul>\n${some('chapters/')}\n</ul>\n` +
    `<h2>Documents</h2>\n<ul>\n${some('docs/')}\n</ul>`;
}

function layout({page, title, headings, body, order, chapter, formulas}) {
  const up = (file) => from(page, file);
  const turn = (step, word, rel) => order >= 0 && documents[order + step]
    ? `<a rel="${rel}" href="${from(page, pageOf(documents[order + step]))}"><span>${word}</span> ${
      escape(titleOf(documents[order + step]))}</a>` : '<span></span>';
  return `<!DOCTYPE html>
<html lang="en">
<head>
<meta charset="utf-8">
<meta name="viewport" content="width=device-width, initial-scale=1">
<meta name="color-scheme" content="light dark">
<title>${escape(title)}${order === 0 ? '' : ' · Constrained dynamics, measured'}</title>
<link rel="icon" href="data:,">
${formulas ? `<link rel="stylesheet" href="${up('katex/katex.css')}">\n` : ''}<link rel="stylesheet" href="${up('style.css')}">
${chapter ? `<script src="${up('scene.js')}" defer></script>\n` : ''}</head>
<body${order < 0 ? ' class="source"' : ''}>
<a class="skip" href="#text">To the text</a>
<header><a href="${up('index.html')}">Constrained dynamics, measured</a>${
  order < 0 ? '' : ' <a class="to-contents" href="#contents">Contents</a>'}</header>
<main id="text">
${body}
<nav class="turn" aria-label="Next and previous">${turn(-1, 'Previous', 'prev')}${turn(1, 'Next', 'next')}</nav>
</main>
${order < 0 ? '' : `<nav id="contents" aria-label="Contents">
${contents(page, headings)}
</nav>
`}</body>
</html>
`;
}

// ---------------------------------------------------------------------------------------------------------
// all of it

let formulas = 0;
documents.forEach((file, order) => {
  const page = pageOf(file);
  const chapter = scenes && file.startsWith('chapters/') ? file.split('/')[1] : '';  // that comes alive
  const env = {file, page, chapter, headings: [], formulas: 0, pictures: 0};
  let body = md.render(read(file), env);
  // The first picture of a chapter is its scene, which comes alive where the book has it.
  if (chapter) {
    body = body.replace('<figure>', `<figure id="scene" data-chapter="${chapter}">`);
    write(`scenes/${chapter}.js`, fs.readFileSync(path.join(scenes, `${chapter}.js`)));
  }
  write(page, layout({page, title: titleOf(file), headings: env.headings, body, order, chapter, formulas: env.formulas}));
  formulas += env.formulas;
});

for (const file of sources) {  // a folder adds to them
  const folder = fs.statSync(path.join(source, file)).isDirectory(), page = pageOfSource(file);
  const body = folder
    ? `<ul>${list(file).filter((name) => !name.startsWith('.')).map((name) =>
      `<li><a href="${from(page, pageOfSource(`${file}/${name}`))}">${escape(name)}</a></li>`).join('\n')}</ul>`
    : `<pre tabindex="0"><code>${colour(read(file), {cpp: 'cpp', hpp: 'cpp', yml: 'yaml', json: 'json', js: 'javascript',
      sh: 'bash'}[path.extname(file).slice(1)] || '')}</code></pre>`;
  write(page, layout({page, title: file, headings: [], body: `<h1 class="file">${escape(file)}</h1>\n${body}`, order: -1}));
}

for (const file of pictures) {
  const target = path.join(out, file.replace(/png$/, 'webp')), made = fs.statSync(path.join(source, file));
  if (!fs.existsSync(target) || fs.statSync(target).mtimeMs < made.mtimeMs) {
    fs.mkdirSync(path.dirname(target), {recursive: true});
    execFileSync('cwebp', ['-quiet', '-lossless', '-z', '3', path.join(source, file), '-o', target]);
  }
  written.webp = (written.webp || 0) + fs.statSync(target).size;
}

for (const name of scenes ? ['style.css', 'scene.js'] : ['style.css']) write(name, fs.readFileSync(path.join(__dirname, name)));
const setter = path.join(path.dirname(require.resolve('katex/package.json')), 'dist');
const css = fs.readFileSync(path.join(setter, 'katex.min.css'), 'utf8')
  .replace(/,url\([^)]*\.(woff|ttf)\) format\('\w+'\)/g, '');  // every browser of today reads WOFF2
write('katex/katex.css', css);
for (const [, font] of css.matchAll(/url\(fonts\/([^)]*)\)/g))
  write(`katex/fonts/${font}`, fs.readFileSync(path.join(setter, 'fonts', font)));

for (const fault of faults) console.error(fault);
const kinds = Object.entries(written).map(([kind, bytes]) => `${kind} ${(bytes / 1e6).toFixed(2)} MB`);
console.log(`${documents.length} documents, ${sources.size} sources, ${formulas} formulas, ${faults.length} faults; ${kinds.join(', ')}`);
process.exit(faults.length ? 1 : 0);
