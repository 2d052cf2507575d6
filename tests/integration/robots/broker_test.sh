#!/usr/bin/env bash
# broker_test.sh PLUMBLINE_ROBOTS MAKE_JOB SOURCE WORK: jobs through a real mosquitto on loopback to a robot that is not ours
# (npm: vda-5050-lib). The program is killed again and again, the broker goes away; then TLS with user names. Exit code 77: skipped.
set -euo pipefail
robots=$1 make_job=$2 source=$3 work=$4
skip() { echo "skipped: $1"; exit 77; }
command -v node > /dev/null || skip "node is not installed"
command -v npm > /dev/null || skip "npm is not installed"
mosquitto=$(PATH=$PATH:/usr/sbin command -v mosquitto) || skip "mosquitto is not installed"
mkdir -p "$work/npm"
if ! cmp -s "$source/package-lock.json" "$work/npm/installed.json"; then
  cp "$source/package.json" "$source/package-lock.json" "$work/npm"
  (cd "$work/npm" && npm ci --no-audit --no-fund --ignore-scripts > npm.log 2>&1) || skip "npm cannot install the robot; see $work/npm/npm.log"
  cp "$source/package-lock.json" "$work/npm/installed.json"
fi
run=$work/run
rm -rf "$run"
mkdir -p "$run"
cd "$run"
started=()
trap '((${#started[@]})) && kill "${started[@]}" 2> /dev/null || true' EXIT
fail() { echo "FAILED: $1"; tail -n 30 ./*.log; exit 1; }
port=$((20000 + RANDOM % 20000))
start_broker() {
  "$mosquitto" -c "$1" > broker.log 2>&1 &
  broker=$! started+=($!)
}
# Not before the robot is connected is the broker taken away: a first connection that fails ends the robot.
start_robot() {
  (cd "$work/npm" && exec node "$source/robot.mjs" "$@") > robot.log 2>&1 &
  robot=$! started+=($!)
  for _ in {1..150}; do grep -q ready robot.log && return; sleep 0.2; done
  fail "the robot did not find the broker"
}
# Each action was done once, and the states on disk say so.
check() {
  [[ $(sort "done_$1" | uniq -d | wc -l) == 0 ]] || fail "an action was done twice"
  [[ $(wc -l < "done_$1") == "$2" ]] || fail "$(wc -l < "done_$1") of $2 actions were done"
  [[ $(tail -n 1 "spool_$1/states.jsonl" | grep -o '"FINISHED"' | wc -l) == "$2" ]] || fail "the states on disk do not hold $2 ends"
}

printf 'listener %s 127.0.0.1\nallow_anonymous true\npersistence false\n' "$port" > plain.conf
start_broker plain.conf
"$make_job" plain.json 6 job-plain
start_robot "mqtt://127.0.0.1:$port" "$run/done_plain"
call=("$robots" --job plain.json --robot RobotCompany/001 --folder spool_plain --port "$port")
# Killed five times, at whatever it was doing; the broker goes away in between and comes back empty.
for pause in 0.3 0.7 0.4 1.1 0.6; do
  "${call[@]}" >> plain.log 2>&1 &
  killed=$!
  sleep "$pause"
  kill -9 "$killed" 2> /dev/null || true
  wait "$killed" 2> /dev/null || true
  if [[ $pause == 0.4 ]]; then kill "$broker"; wait "$broker" 2> /dev/null || true; sleep 0.5; start_broker plain.conf; fi
done
timeout 60 "${call[@]}" --longest 50 >> plain.log 2>&1 || fail "the job did not come to its end"
check plain 6
# Asked again nothing is done again.
timeout 30 "${call[@]}" --longest 20 >> plain.log 2>&1 || fail "a job at its end is not known as such"
check plain 6
# Nor after its time, which is for what was not begun.
sed 's/"revision": 1,/&\n "validUntil": "2020-01-01T00:00:00Z",/;' plain.json | awk '!/validUntil/ || !n++' > late.json
timeout 30 "${call[@]/plain.json/late.json}" --longest 20 >> plain.log 2>&1 || fail "what the robot had done in time was not taken later"
code=0
"$robots" --job late.json --robot RobotCompany/001 --folder spool_late --port "$port" --longest 5 > late.log 2>&1 || code=$?
[[ $code == 3 ]] || fail "a job after its time ends with exit code $code, not 3"
grep -q 'was valid until 2020' late.log || fail "it was not said that the job is too old"
# What one robot has is not given to another, which has a folder of its own.
code=0
"$robots" --job plain.json --robot RobotCompany/002 --folder spool_second --port "$port" --longest 5 > second.log 2>&1 || code=$?
[[ $code == 3 ]] || fail "a job that another robot has ends with exit code $code, not 3"
grep -q 'F01-C01-R1.* were given to RobotCompany/001' second.log || fail "it was not said who has the job"
# A second program on the same folder, another host without TLS.
for host in 192.0.2.1 127.0.0.1.example.invalid 127.example.invalid; do
  if "$robots" --job plain.json --robot RobotCompany/001 --folder spool_other --host "$host" --longest 1 > other.log 2> refused.log; then fail "a plain connection to another machine was tried"; fi
  grep -q 'give --ca' refused.log || fail "it was not said why $host is refused"
done
kill "$robot"; wait "$robot" 2> /dev/null || true

# The client of the documents, started again in the middle of its second action: it says FAILED of that, does the rest, and the exit code tells.
if /usr/bin/python3 -c 'import paho.mqtt.client' 2> /dev/null; then
  "$make_job" failed.json 3 job-failed
  echo '{"job-failed:F01-C02-R1:1": null}' > done_002.json
  /usr/bin/python3 "$source/../../../docs/examples/robot_client.py" RobotCompany 002 127.0.0.1 "$port" > client.log 2>&1 &
  client=$! started+=($!)
  code=0
  timeout 60 "$robots" --job failed.json --robot RobotCompany/002 --folder spool_failed --port "$port" --longest 50 > failed.log 2>&1 || code=$?
  [[ $code == 4 ]] || fail "a job with an action that FAILED ends with exit code $code, not 4"
  grep -q 'the robot FAILED on F01-C02-R1: see to why' failed.log || fail "it was not said what FAILED"
  [[ $(tail -n 1 spool_failed/states.jsonl | grep -o '"FINISHED"' | wc -l) == 2 ]] || fail "what did not fail was not done"
  kill "$client"; wait "$client" 2> /dev/null || true
else
  echo "without the Python client: python3-paho-mqtt is not installed"
fi
kill "$broker"; wait "$broker" 2> /dev/null || true

# TLS, user name and password, a signed job; the wrong password and a changed job are refused.
openssl req -x509 -newkey rsa:2048 -nodes -days 2 -subj /CN=127.0.0.1 -addext "subjectAltName=IP:127.0.0.1" -keyout broker.key -out broker.crt 2> openssl.log
openssl genpkey -algorithm ed25519 -out signer.pem 2>> openssl.log
openssl pkey -in signer.pem -pubout -out signer_public.pem
mosquitto_passwd -c -b users plumbline secret && mosquitto_passwd -b users robot other
chmod 600 users broker.key
printf 'listener %s 127.0.0.1\nallow_anonymous false\npassword_file %s\ncertfile %s\nkeyfile %s\npersistence false\nuser root\n' \
  "$port" "$run/users" "$run/broker.crt" "$run/broker.key" > tls.conf
start_broker tls.conf
"$make_job" tls.json 3 job-tls
openssl pkeyutl -sign -rawin -inkey signer.pem -in tls.json -out tls.json.sig
echo secret > password
start_robot "mqtts://127.0.0.1:$port" "$run/done_tls" "$run/broker.crt" robot other
tls=("$robots" --job tls.json --robot RobotCompany/001 --folder spool_tls --port "$port" --ca broker.crt --user plumbline --public-key signer_public.pem)
echo wrong > wrong_password
if timeout 20 "${tls[@]}" --password-file wrong_password --longest 3 > wrong.log 2>&1; then fail "a wrong password was taken"; fi
grep -q 'the broker refuses' wrong.log || fail "it was not said that the broker refuses"
sed 's/"up": 0.004/"up": 0.005/' tls.json > changed.json
cp tls.json.sig changed.json.sig
if "${tls[@]/tls.json/changed.json}" --password-file password --longest 3 > changed.log 2>&1; then fail "a job that was changed was taken"; fi
timeout 60 "${tls[@]}" --password-file password --longest 50 >> tls.log 2>&1 || fail "the job over TLS did not come to its end"
check tls 3
echo "done: $(cat plain.log tls.log | wc -l) lines said"
