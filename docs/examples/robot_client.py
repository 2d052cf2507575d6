#!/usr/bin/env python3
# A robot of VDA 5050 2.0: takes an order, does its actions, says so. For integrators: replace do_it().
# usage: robot_client.py MANUFACTURER SERIAL [HOST [PORT]]     (Debian: python3-paho-mqtt)
import datetime, json, os, sys, time
import paho.mqtt.client as mqtt

MANUFACTURER, SERIAL = sys.argv[1:3]
HOST, PORT = (sys.argv[3:] + ["127.0.0.1", "1883"][len(sys.argv) - 3:])[:2]
TOPIC = f"uagv/v2/{MANUFACTURER}/{SERIAL}/"
DONE = f"done_{SERIAL}.json"  # what was done, on disk: nothing is done twice, also after a restart
done = json.load(open(DONE)) if os.path.exists(DONE) else {}
state = {"orderId": "", "orderUpdateId": 0, "actions": [], "header": 0}
todo = []

def do_it(action):
    """Does one item, and measures where it is afterwards: not the number that was asked for."""
    asked = {p["key"]: p["value"] for p in action["actionParameters"]}
    time.sleep(0.2)  # asked["actionType"] at asked["targetPosition"], set by asked["setting"]
    return {"measured": [x + 0.0004 for x in asked["targetPosition"]], "note": "done by " + SERIAL}

def remember(key, result):
    done[key] = result
    json.dump(done, open(DONE, "w"))

def send_state(client):
    state["header"] += 1
    client.publish(TOPIC + "state", json.dumps({
        "headerId": state["header"], "version": "2.0.0", "manufacturer": MANUFACTURER,
        "timestamp": datetime.datetime.utcnow().isoformat(timespec="milliseconds") + "Z",
        "serialNumber": SERIAL, "orderId": state["orderId"], "orderUpdateId": state["orderUpdateId"], "lastNodeId": "",
        "lastNodeSequenceId": 0, "driving": False, "operatingMode": "AUTOMATIC", "nodeStates": [], "edgeStates": [],
        "actionStates": state["actions"], "batteryState": {"batteryCharge": 80, "charging": False}, "errors": [],
        "safetyState": {"eStop": "NONE", "fieldViolation": False}}), qos=1)

def on_message(client, _, message):
    order = json.loads(message.payload)
    if message.topic.endswith("instantActions") or order["orderId"] == state["orderId"]:
        return send_state(client)  # asked for, or the order that it has
    if any(s["actionStatus"] not in ("FINISHED", "FAILED") for s in state["actions"]):
        return send_state(client)  # still at work: the new order is not taken
    todo[:] = [action for node in order["nodes"] for action in node["actions"]]
    state.update(orderId=order["orderId"], orderUpdateId=order["orderUpdateId"], actions=[
        {"actionId": a["actionId"], "actionType": a["actionType"], "actionStatus": "WAITING"} for a in todo])

client = mqtt.Client(client_id=SERIAL)
client.on_message = on_message
client.on_connect = lambda c, *_: (c.subscribe([(TOPIC + "order", 1), (TOPIC + "instantActions", 1)]), send_state(c))
client.connect(HOST, int(PORT))
while True:
    client.loop(timeout=1.0)
    for action, status in zip(todo, state["actions"]):
        if status["actionStatus"] == "WAITING":
            key = action["actionId"]
            if key not in done:
                remember(key, None)  # begun: if it is not ended after a restart, nobody knows, and it has failed
                remember(key, json.dumps(do_it(action)))
            status.update(actionStatus="FINISHED" if done[key] else "FAILED",
                          resultDescription=done[key] or "interrupted")
            send_state(client)
            break
