#!/usr/bin/env bash
# rusticl.sh EVENSTEP PROGRAM... : runs PROGRAM with Mesa's rusticl as the only OpenCL: a compiler, a memory and names that
# are not PoCL's. It computes on the processor. Exit status 77 where it is not there.
set -euo pipefail
icd=/etc/OpenCL/vendors/rusticl.icd
[[ -e $icd ]] || { echo 'skipped: rusticl is not installed (Debian: mesa-opencl-icd)'; exit 77; }
export OCL_ICD_VENDORS=$icd RUSTICL_ENABLE=llvmpipe
devices=$("$1" devices --opencl)
[[ $devices == *'(rusticl)'* ]] || { echo "skipped: rusticl has no device here: $devices"; exit 77; }
exec "${@:2}"
