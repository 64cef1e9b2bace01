# SPDX-License-Identifier: BSD-3-Clause
add_subdirectory(lcmtypes)
pkg_check_modules(SYSTEMD REQUIRED IMPORTED_TARGET libsystemd)

# Estimates out over LCM (replay uses it too), and the way of a frame on threads.
add_library(cliquevo_daemon_lib STATIC
  command.cpp command_receiver.cpp control_client.cpp control_session.cpp control_socket.cpp effective_config.cpp feature_tap.cpp first_pairs.cpp health.cpp
  image_tap.cpp incidents.cpp lcm_url.cpp local_addresses.cpp log_names.cpp machine.cpp message_sender.cpp messages.cpp
  pipeline.cpp publisher.cpp recording.cpp rectified_size.cpp source.cpp standard_streams.cpp status_report.cpp tcpq_client.cpp
  trajectory_sink.cpp)
target_link_libraries(cliquevo_daemon_lib
  PUBLIC cliquevo_options cliquevo_base cliquevo_rt cliquevo_pipeline cliquevo_lcmtypes
  PRIVATE cliquevo_trajectory fmt::fmt nlohmann_json::nlohmann_json spdlog::spdlog)

add_executable(cliquevod main.cpp commands.cpp daemon.cpp log.cpp service.cpp signals.cpp start_up.cpp)
target_link_libraries(cliquevod PRIVATE
  cliquevo_daemon_lib cliquevo_drivers CLI11::CLI11 fmt::fmt spdlog::spdlog PkgConfig::SYSTEMD)
target_compile_definitions(cliquevod PRIVATE CLIQUEVO_VERSION="${PROJECT_VERSION}")
