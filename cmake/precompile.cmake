# SPDX-License-Identifier: BSD-3-Clause
# Precompiled headers: the first build on a machine takes much less, and no later one, since a compiler cache keeps nothing
# that uses them. tools/demo builds so.
option(CLIQUEVO_PRECOMPILE "Precompile the largest headers of the largest libraries" OFF)
if(NOT CLIQUEVO_PRECOMPILE)
  return()
endif()

# Sources with options of their own (an instruction set) cannot use their library's.
function(cliquevo_precompile target)
  if(NOT TARGET ${target})
    return()
  endif()
  target_precompile_headers(${target} PRIVATE ${ARGN})
  get_target_property(sources ${target} SOURCES)
  foreach(source ${sources})
    get_source_file_property(options ${source} TARGET_DIRECTORY ${target} COMPILE_OPTIONS)
    if(options)
      set_source_files_properties(${source} TARGET_DIRECTORY ${target} PROPERTIES SKIP_PRECOMPILE_HEADERS ON)
    endif()
  endforeach()
endfunction()

set(standard <string> <vector> <memory> <functional> <algorithm>)
set(numeric ${standard} <Eigen/Core> <Eigen/Geometry>)
set(texts ${numeric} <filesystem> <fmt/format.h> <fmt/ranges.h>)
cliquevo_precompile(cliquevo_vo ${numeric} <Eigen/Cholesky> <Eigen/Eigenvalues>)
cliquevo_precompile(cliquevo_simulator ${numeric})
cliquevo_precompile(cliquevo_calibration ${texts})
cliquevo_precompile(cliquevo_recording ${texts})
cliquevo_precompile(cliquevo_pipeline ${texts} ${PROJECT_SOURCE_DIR}/daemon/pipeline/config.h)
cliquevo_precompile(cliquevo_lcm ${texts} <nlohmann/json.hpp>)
cliquevo_precompile(cliquevo_tools ${texts} <CLI/CLI.hpp> <nlohmann/json.hpp> ${PROJECT_SOURCE_DIR}/daemon/pipeline/config.h)
