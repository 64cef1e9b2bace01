# SPDX-License-Identifier: BSD-3-Clause
add_subdirectory(lcmtypes)

# Estimates out over LCM; replay uses it too.
add_library(cliquevo_daemon_lib STATIC lcm_url.cpp messages.cpp publisher.cpp)
target_link_libraries(cliquevo_daemon_lib PUBLIC cliquevo_options cliquevo_base cliquevo_lcmtypes)
