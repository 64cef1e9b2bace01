# SPDX-License-Identifier: BSD-3-Clause
# Fleets: on this machine, and on a Slurm of two nodes on it.
add_library(crash_on_open MODULE crash_on_open.c)
set_target_properties(crash_on_open PROPERTIES PREFIX "")

cliquevo_add_system_test(test_fleet SOURCES fleet_test.cpp
  LIBRARIES fmt::fmt nlohmann_json::nlohmann_json DEPENDS cliquevo crash_on_open)
target_compile_definitions(test_fleet PRIVATE CLIQUEVO_CRASH_ON_OPEN="$<TARGET_FILE:crash_on_open>")

# Slurm waits two minutes before it begins a dead node's work elsewhere.
cliquevo_add_test(test_fleet_slurm bench SOURCES fleet_slurm_test.cpp
  LIBRARIES fmt::fmt nlohmann_json::nlohmann_json DEPENDS cliquevo TIMEOUT 1200
  ENVIRONMENT "CLIQUEVO_CACHE=${PROJECT_BINARY_DIR}/renders")
target_compile_definitions(test_fleet_slurm PRIVATE
  CLIQUEVO_SLURM_CLUSTER="${CMAKE_CURRENT_SOURCE_DIR}/slurm/cluster")

# A thousand units: minutes.
cliquevo_add_test(test_fleet_many bench SOURCES fleet_many_test.cpp
  LIBRARIES fmt::fmt nlohmann_json::nlohmann_json DEPENDS cliquevo TIMEOUT 3600
  ENVIRONMENT "CLIQUEVO_CACHE=${PROJECT_BINARY_DIR}/renders")
