#!/usr/bin/env bash
# The Debian packages: lintian finds no error, and what is in them runs a pipeline from where they are unpacked.
# usage: package.sh SOURCE BUILD FOLDER     with PLUMBLINE_LONG also on a bare root made by debootstrap, with what the package depends on
set -euo pipefail
source=$1 build=$2 folder=$3
command -v dpkg-deb >/dev/null && command -v dpkg-shlibdeps >/dev/null || { echo "SKIPPED: this is no Debian system that makes packages"; exit 77; }
rm -rf "$folder"
mkdir -p "$folder"
"$source/scripts/package" "$build"
packages=("$build"/package/plumbline_*.deb "$build"/package/plumbline-dev_*.deb)
if command -v lintian >/dev/null; then
  lintian --allow-root --fail-on error "${packages[@]}"
else
  echo "lintian is not installed (scripts/setup --tests): the packages were not checked"
fi
for package in "${packages[@]}"; do dpkg-deb -x "$package" "$folder/root"; done
cd "$folder"
# Nothing of the build folder: its plugins are not on the path and the program finds its own.
env -u PLUMBLINE_PLUGIN_PATH root/usr/bin/plumbline run full_height floors=1 --out out || { code=$?; [[ $code == 3 ]] || exit $code; }
[[ -s out/as_built.ifc && -s out/report.html ]]
if grep -q "\"$build/lib/plumbline" out/run.jsonl; then echo "plugins of the build folder were taken" >&2; exit 1; fi
zcat root/usr/share/man/man1/plumbline.1.gz | grep 'plumbline' > /dev/null
[[ -f root/usr/share/bash-completion/completions/plumbline && -f root/usr/share/zsh/vendor-completions/_plumbline && -f root/usr/share/fish/vendor_completions.d/plumbline.fish ]]
[[ -f root/usr/lib/cmake/Plumbline/PlumblineConfig.cmake ]]
[[ -n "${PLUMBLINE_LONG:-}" ]] || exit 0

debootstrap --variant=minbase "$(. /etc/os-release && echo "$VERSION_CODENAME")" bare >/dev/null
cp "${packages[0]}" bare/tmp/plumbline.deb
chroot bare sh -c 'apt-get update -qq && DEBIAN_FRONTEND=noninteractive apt-get install -y -qq --no-install-recommends /tmp/plumbline.deb' >/dev/null
chroot bare sh -c 'cd /tmp && plumbline run full_height floors=3 --out demo' || { code=$?; [[ $code == 3 ]] || exit $code; }
[[ -s bare/tmp/demo/as_built.ifc ]]
