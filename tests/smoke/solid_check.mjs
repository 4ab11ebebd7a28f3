// SPDX-License-Identifier: Apache-2.0
// Opens solids with other people's programs and says what these found in them.
//   node solid_check.mjs PLACE-OF-node_modules FILE.glb FILE.wrl FILE.ply
// glTF: Khronos' validator, which may find no error and no warning. VRML and PLY: the loaders of
// three.js. All three must hold the same faces.
import fs from 'node:fs';
import path from 'node:path';
import { createRequire } from 'node:module';
import { pathToFileURL } from 'node:url';

const [place, ...files] = process.argv.slice(2);
const require = createRequire(path.join(place, 'check.js'));
const module_of = (name) => import(pathToFileURL(path.join(place, 'node_modules', name)).href);
const file_of = (end) => files.find((f) => f.endsWith(end));
const fail = (what) => { console.error(what); process.exit(1); };

async function gltf(file) {
  const { issues, info } = await require('gltf-validator').validateBytes(new Uint8Array(fs.readFileSync(file)));
  if (issues.numErrors + issues.numWarnings > 0) fail(`${file}: ${JSON.stringify(issues.messages.slice(0, 5))}`);
  return { parts: info.drawCallCount, triangles: info.totalTriangleCount };
}

function triangles_of(geometry) {
  return (geometry.index ? geometry.index.count : geometry.attributes.position.count) / 3;
}

// m, with 1 mm: lowest and highest x, y, z.
function box_of(three, object) {
  object.updateMatrixWorld(true);
  const box = new three.Box3().setFromObject(object);
  return [...box.min.toArray(), ...box.max.toArray()].map((v) => Number(v.toFixed(3)));
}

async function vrml(file, three) {
  const { VRMLLoader } = await module_of('three/examples/jsm/loaders/VRMLLoader.js');
  const scene = new VRMLLoader().parse(fs.readFileSync(file, 'utf8'), '');
  let parts = 0, triangles = 0;
  scene.traverse((node) => {
    if (node.isPoints) ++parts;
    if (!node.isMesh) return;
    if (!node.geometry.attributes.color || !node.geometry.attributes.normal) fail(`${file}: a part without colours or normals`);
    ++parts;
    triangles += triangles_of(node.geometry);
  });
  return { parts, triangles, box: box_of(three, scene) };
}

async function ply(file, three) {
  const { PLYLoader } = await module_of('three/examples/jsm/loaders/PLYLoader.js');
  const bytes = fs.readFileSync(file);
  const geometry = new PLYLoader().parse(bytes.buffer.slice(bytes.byteOffset, bytes.byteOffset + bytes.length));
  for (const name of ['position', 'normal', 'color'])
    if (!geometry.attributes[name]) fail(`${file}: no ${name}`);
  // The map's z up, as the other two files have it turned.
  geometry.rotateX(-Math.PI / 2);
  return { triangles: geometry.index ? triangles_of(geometry) : 0, box: box_of(three, new three.Mesh(geometry)) };
}

const three = await module_of('three/build/three.module.js');
const seen = { glb: await gltf(file_of('.glb')), wrl: await vrml(file_of('.wrl'), three), ply: await ply(file_of('.ply'), three) };
console.log(JSON.stringify(seen));
if (seen.glb.triangles !== seen.wrl.triangles || seen.glb.triangles !== seen.ply.triangles) fail('not the same triangles');
if (seen.glb.parts !== seen.wrl.parts) fail('not the same parts');
if (seen.wrl.box.some((v, i) => Math.abs(v - seen.ply.box[i]) > 0.002)) fail('not the same place');
