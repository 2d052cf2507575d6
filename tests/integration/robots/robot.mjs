// robot.mjs BROKER-URL LOG [CA USER PASSWORD]: a robot of VDA 5050 2.0 that is not ours: vda-5050-lib's AgvController with its
// virtual vehicle, which knows what our jobs ask for. LOG gets a line for each action that it finishes.
import { appendFileSync, readFileSync } from "node:fs";
import { createRequire } from "node:module";

const require = createRequire(process.cwd() + "/");
const { ActionStatus, AgvController, VirtualAgvAdapter } = require("vda-5050-lib");
const [brokerUrl, log, ca, username, password] = process.argv.slice(2);

class FacadeRobot extends VirtualAgvAdapter {
  get actionDefinitions() {
    const action = (actionType) => ({
      actionType,
      actionScopes: "node",
      actionExecutable: () => "",
      transitions: {
        ON_INIT: { next: ActionStatus.Running },
        ON_CANCEL: {},
        [ActionStatus.Running]: { durationTime: 8, next: ActionStatus.Finished },
        [ActionStatus.Finished]: {
          resultDescription: ({ action }) => {
            appendFileSync(log, action.actionId + "\n");
            const value = (key) => action.actionParameters.find((p) => p.key === key)?.value;
            return JSON.stringify({ measured: value("targetPosition").map((x) => x + 0.0007), note: "done by robot 001" });
          },
        },
        [ActionStatus.Failed]: { errorDescription: () => "failed" },
      },
    });
    return [action("setBracket"), action("placePanel")];
  }
}

const tls = ca ? { tlsOptions: { ca: readFileSync(ca), rejectUnauthorized: true } } : {};
const robot = new AgvController(
  { manufacturer: "RobotCompany", serialNumber: "001" },
  { interfaceName: "uagv", vdaVersion: "2.0.0",
    transport: { brokerUrl, connectTimeout: 2000, reconnectPeriod: 500, ...(username ? { username, password } : {}), ...tls } },
  { agvAdapterType: FacadeRobot, publishStateInterval: 2000 },
  { timeLapse: 20, initialPosition: { mapId: "floor-1", x: -3, y: 0, theta: 0, lastNodeId: "parking" } });
process.on("SIGTERM", async () => { await robot.stop().catch(() => {}); process.exit(0); });
await robot.start();
console.log("ready");
