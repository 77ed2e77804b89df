#!/bin/sh
# SPDX-License-Identifier: GPL-3.0-or-later
# Isotropic, parallel and arc fibres on one valve, as papers/s2 compares them: the same HGO tissue with both fibre maps, and the Ogden tissue that
# s2 fitted to its isotropic limit. Expected order of bulging.volume_ml: isotropic > parallel > arc.
#   configs/fibre_study.sh CONFIG DIR [--set key=value ...]
# mvprep and mvsolve are taken from PATH, or from BIN.
set -eu
[ $# -ge 2 ] || { echo "usage: $0 CONFIG DIR [--set key=value ...]" >&2; exit 2; }
config=$1 out=$2
shift 2
bin=${BIN:+$BIN/}
threads=${THREADS:-2}
mkdir -p "$out"
for model in isotropic parallel arc; do
  case $model in
    isotropic) law=ogden fibres=none ;;
    *) law=hgo fibres=$model ;;
  esac
  "${bin}mvprep" run -c "$config" -o "$out/$model.case" --set fibers.model=$fibres --set leaflet.anterior.law=$law --set leaflet.posterior.law=$law "$@"
  "${bin}mvsolve" run "$out/$model.case" -o "$out/$model" --threads "$threads"
done
"${bin}mvsolve" compare "$out/isotropic" "$out/parallel" "$out/arc" --names isotropic,parallel,arc -o "$out"
