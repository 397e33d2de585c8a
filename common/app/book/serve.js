// Serves a folder on the loopback address:
//
//   node serve.js FOLDER [PORT]      says where; without a port, or with one that is taken, on a free one
'use strict';
const fs = require('fs');
const http = require('http');
const path = require('path');

const kinds = {html: 'text/html; charset=utf-8', css: 'text/css', js: 'text/javascript; charset=utf-8', webp: 'image/webp', woff2: 'font/woff2'};

/// Promises the server, which listens.
function serve(folder, port = 0) {
  const root = path.resolve(folder);
  const server = http.createServer((request, answer) => {
    let file = path.join(root, path.normalize(decodeURIComponent(request.url.replace(/[?#].*$/, ''))));
    if (file.startsWith(root) && file.endsWith('/')) file += 'index.html';
    fs.readFile(file, (error, content) => {
      if (error || !file.startsWith(root)) return answer.writeHead(404).end('no such page');
      answer.writeHead(200, {'Content-Type': kinds[path.extname(file).slice(1)] || 'text/plain; charset=utf-8'}).end(content);
    });
  });
  return new Promise((done, failed) => server.on('listening', () => done(server)).on('error', (error) =>
    error.code === 'EADDRINUSE' && port ? server.listen((port = 0), '127.0.0.1') : failed(error)).listen(port, '127.0.0.1'));
}

module.exports = {serve};
if (require.main === module)
  serve(process.argv[2], Number(process.argv[3] || 0)).then((server) =>
    console.log(`the book is at http://127.0.0.1:${server.address().port}/ until Ctrl-C`));
