// Writes the files of a folder, compressed, as a C++ source. usage: node embed_page.mjs FOLDER OUT.cpp
import { readFileSync, readdirSync, statSync, writeFileSync } from 'node:fs';
import { join, relative, sep } from 'node:path';
import { gzipSync } from 'node:zlib';

const [folder, out] = process.argv.slice(2);

function filesOf(where) {
    return readdirSync(where).sort().flatMap((name) => {
        const path = join(where, name);
        return statSync(path).isDirectory() ? filesOf(path) : [path];
    });
}

function arrayOf(bytes) {
    const lines = [];
    for (let at = 0; at < bytes.length; at += 32) lines.push(Array.from(bytes.subarray(at, at + 32)).join(','));
    return lines.join(',\n');
}

const files = filesOf(folder);
const names = files.map((file) => relative(folder, file).split(sep).join('/'));
if (!names.includes('index.html')) {
    console.error(`embed_page: ${folder} has no index.html; build the page first: npm run build`);
    process.exit(1);
}
const arrays = files.map((file, k) => {
    const bytes = gzipSync(readFileSync(file), { level: 9 });
    return `constexpr std::uint8_t kFile${k}[] = {\n${arrayOf(bytes)}};\n`;
});
const entries = names.map((name, k) => `    {${JSON.stringify(name)}, kFile${k}},\n`);
writeFileSync(out, `#include "assets.h"

namespace relief::editor::detail {

namespace {

${arrays.join('\n')}
constexpr Asset kAssets[] = {
${entries.join('')}};

}  // namespace

std::span<const Asset> all_assets() {
    return kAssets;
}

}  // namespace relief::editor::detail
`);
