# SPDX-License-Identifier: BSD-3-Clause
add_subdirectory(lcmtypes)

# Estimates out over LCM (replay uses it too), and the way of a frame on threads.
add_library(cliquevo_daemon_lib STATIC lcm_url.cpp messages.cpp pipeline.cpp publisher.cpp stages.cpp)
target_link_libraries(cliquevo_daemon_lib
  PUBLIC cliquevo_options cliquevo_base cliquevo_rt cliquevo_stereo cliquevo_vo cliquevo_lcmtypes)
