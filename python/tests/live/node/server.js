// An OPC UA server of node-opcua that plays a recording: node server.js PORT FILE SPEED FOLDER
// FILE is JSON: {"TAG": [[ms since 1970, value], ...]}. It listens on 127.0.0.1 only, and plays after the line "play" on
// standard input. Keys are kept in FOLDER.
import { readFileSync } from "node:fs";
import { createInterface } from "node:readline";
import { DataType, DataValue, MessageSecurityMode, OPCUACertificateManager, OPCUAServer, SecurityPolicy, StatusCodes, Variant } from "node-opcua";

const [port, file, speed, folder] = process.argv.slice(2);
const data = JSON.parse(readFileSync(file, "utf8"));
const begin = Math.min(...Object.values(data).map((own) => own[0][0]));
const end = Math.max(...Object.values(data).map((own) => own.at(-1)[0]));
let clock = begin;
const requests = {};

const serverCertificateManager = new OPCUACertificateManager({ automaticallyAcceptUnknownCertificate: true, rootFolder: `${folder}/pki` });
await serverCertificateManager.initialize();
const server = new OPCUAServer({
  port: Number(port),
  hostname: "127.0.0.1",
  host: "127.0.0.1",
  serverCertificateManager,
  allowAnonymous: true,
  securityPolicies: [SecurityPolicy.None, SecurityPolicy.Basic256Sha256],
  securityModes: [MessageSecurityMode.None, MessageSecurityMode.SignAndEncrypt],
  serverInfo: { applicationUri: "urn:stiction:node" },
});
server.on("request", (request) => {
  const name = request.schema?.name ?? request.constructor.name;
  requests[name] = (requests[name] ?? 0) + 1;
});
await server.initialize();
const space = server.engine.addressSpace;
const own = space.getOwnNamespace();
const plant = own.addObject({ organizedBy: space.rootFolder.objects, browseName: "Plant" });
const nodes = {};
for (const tag of Object.keys(data)) {
  nodes[tag] = own.addVariable({
    componentOf: plant,
    browseName: tag,
    nodeId: `s=${tag}`,
    dataType: DataType.Double,
    minimumSamplingInterval: 0,
  });
  nodes[tag].setValueFromSource({ dataType: DataType.Double, value: data[tag][0][1] }, StatusCodes.BadWaitingForInitialData, new Date(begin - 1000));
}
// The clock of the recording.
const time = space.findNode("ns=0;i=2258");
time.readValue = () =>
  new DataValue({
    value: new Variant({ dataType: DataType.DateTime, value: new Date(clock) }),
    sourceTimestamp: new Date(clock),
    statusCode: StatusCodes.Good,
  });
await server.start();
console.log(JSON.stringify({ listening: Number(port), tags: Object.keys(data).length, begin: 1000 * begin, end: 1000 * end }));

const next = Object.fromEntries(Object.keys(data).map((tag) => [tag, 0]));
const play = () => {
  const started = performance.now();
  setInterval(() => {
    const now = begin + (performance.now() - started) * Number(speed);
    // One value of each tag at a time, in order of time.
    for (const [tag, values] of Object.entries(data)) {
      while (next[tag] < values.length && values[next[tag]][0] <= now) {
        const [at, value] = values[next[tag]++];
        nodes[tag].setValueFromSource({ dataType: DataType.Double, value }, StatusCodes.Good, new Date(at));
      }
    }
    clock = now;
  }, 5);
};
createInterface({ input: process.stdin }).on("line", (line) => {
  if (line === "play") play();
  if (line === "requests") console.log(JSON.stringify({ requests }));
  if (line === "quit") void server.shutdown(100).then(() => process.exit(0));
});
