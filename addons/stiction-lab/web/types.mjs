// The types of all calls, from the schema that the crate gives: schema.json, which a test of the crate compares.
import { readFileSync, writeFileSync } from "node:fs";
import { compile } from "json-schema-to-typescript";

const schema = JSON.parse(readFileSync("schema.json", "utf8"));
const types = await compile(schema, "Calls", {
  bannerComment: "// Made by types.mjs from schema.json.",
  style: { printWidth: 120 },
});
writeFileSync("src/types.ts", types);
