// An OPC UA server of node-opcua that plays a recording: node server.js PORT FILE SPEED FOLDER [HISTORY]
// FILE is JSON: {"TAG": [[ms since 1970, value], ...]}. It listens on 127.0.0.1 only, and plays after the line "play" on
// standard input. Keys are kept in FOLDER. HISTORY is the number of values of each tag that it keeps for HistoryRead.
import { readFileSync } from "node:fs";
import { createInterface } from "node:readline";
import { DataType, DataValue, MessageSecurityMode, OPCUACertificateManager, OPCUAServer, SecurityPolicy, StatusCodes, Variant } from "node-opcua";

const [port, file, speed, folder, history] = process.argv.slice(2);
const data = JSON.parse(readFileSync(file, "utf8"));
const tags = Object.keys(data);
// All values in order of time.
const values = tags.flatMap((tag) => data[tag].map(([at, value]) => ({ tag, at, value }))).sort((a, b) => a.at - b.at);
const begin = values[0].at;
const end = values.at(-1).at;
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
  // Each change is reported.
  serverCapabilities: { minSupportedSampleRate: 0 },
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
for (const tag of tags) {
  nodes[tag] = own.addVariable({
    componentOf: plant,
    browseName: tag,
    nodeId: `s=${tag}`,
    dataType: DataType.Double,
    minimumSamplingInterval: 0,
  });
  nodes[tag].setValueFromSource({ dataType: DataType.Double, value: data[tag][0][1] }, StatusCodes.BadWaitingForInitialData, new Date(begin));
  if (history) space.installHistoricalDataNode(nodes[tag], { maxOnlineValues: Number(history) });
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
console.log(JSON.stringify({ listening: Number(port), tags: tags.length, begin: 1000 * begin, end: 1000 * end }));

let next = 0;
const play = () => {
  const started = performance.now();
  setInterval(() => {
    const now = begin + (performance.now() - started) * Number(speed);
    for (; next < values.length && values[next].at <= now; next++) {
      const { tag, at, value } = values[next];
      nodes[tag].setValueFromSource({ dataType: DataType.Double, value }, StatusCodes.Good, new Date(at));
    }
    if (next === values.length && clock <= end) console.log(JSON.stringify({ played: next, seconds: (performance.now() - started) / 1000 }));
    // It stops before the next hour ends, which would be judged, too.
    clock = Math.min(now, Math.ceil(end / 3.6e6) * 3.6e6 + 1.8e6);
  }, 5);
};
createInterface({ input: process.stdin }).on("line", (line) => {
  if (line === "play") play();
  if (line === "requests") console.log(JSON.stringify({ requests }));
  if (line === "quit") void server.shutdown(100).then(() => process.exit(0));
});
