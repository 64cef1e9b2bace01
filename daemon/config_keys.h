// SPDX-License-Identifier: BSD-3-Clause
// The keys of the configuration file, one line each: where a key's value lives. What reads, lists or checks the
// configuration goes over this table; config/cliquevo.yaml must have the same keys (a test compares them).
#pragma once

#include "daemon/config.h"

namespace cliquevo::daemon {

// Calls key(path, value) for every key, file(path, value) for those that name a file or folder, and
// choice(path, value, {{"name", value}, ...}) for those that pick one of a few. C is Config or const Config.
template <typename C, typename Visitor>
void visit_config_keys(C& c, Visitor& v) {
  v.choice("source.type", c.source.type,
           {{"simulator", "simulator"},
            {"recording", "recording"},
            {"aravis", "aravis"},
            {"v4l2", "v4l2"},
            {"libcamera", "libcamera"}});
  v.choice("source.loop", c.source.loop, {{"none", "none"}, {"pingpong", "pingpong"}});
  v.key("source.speed", c.source.speed);
  v.key("source.swap_eyes", c.source.swap_eyes);

  auto& recording = c.source.recording;
  v.file("source.recording.path", recording.path);
  v.file("source.recording.calibration", recording.calibration);
  v.key("source.recording.baseline_unit", recording.calibration_options.baseline_unit_m);
  v.key("source.recording.rectified", recording.calibration_options.rectified);
  v.key("source.recording.lens", recording.calibration_options.lens);
  v.key("source.recording.rate_hz", recording.rate_hz);
  v.key("source.recording.first", recording.first);
  v.key("source.recording.last", recording.last);
  v.key("source.recording.every", recording.every);
  v.key("source.recording.pair_tolerance_s", recording.pair_tolerance_s);
  v.key("source.recording.side_by_side", recording.side_by_side);
  v.key("source.recording.channel", recording.channel);
  v.file("source.recording.left_mask", recording.left_mask);
  v.file("source.recording.right_mask", recording.right_mask);
  v.choice("source.recording.bayer", recording.bayer,
           {{"auto", drivers::Bayer::automatic},
            {"none", drivers::Bayer::none},
            {"rggb", drivers::Bayer::rggb},
            {"bggr", drivers::Bayer::bggr},
            {"grbg", drivers::Bayer::grbg},
            {"gbrg", drivers::Bayer::gbrg}});

  auto& cameras = c.source.cameras;
  v.key("source.cameras.left", cameras.left);
  v.key("source.cameras.right", cameras.right);
  v.file("source.cameras.calibration", cameras.calibration);
  v.key("source.cameras.baseline_unit", cameras.calibration_options.baseline_unit_m);
  v.key("source.cameras.rectified", cameras.calibration_options.rectified);
  v.key("source.cameras.lens", cameras.calibration_options.lens);
  v.key("source.cameras.rate_hz", cameras.rate_hz);
  v.key("source.cameras.width", cameras.width);
  v.key("source.cameras.height", cameras.height);
  v.key("source.cameras.offset_x", cameras.offset_x);
  v.key("source.cameras.offset_y", cameras.offset_y);
  v.key("source.cameras.binning", cameras.binning);
  v.key("source.cameras.pixel_format", cameras.pixel_format);
  v.key("source.cameras.exposure_us", cameras.exposure_us);
  v.key("source.cameras.gain", cameras.gain);
  v.choice("source.cameras.trigger", cameras.trigger,
           {{"off", drivers::CameraTrigger::off},
            {"software", drivers::CameraTrigger::software},
            {"hardware", drivers::CameraTrigger::hardware},
            {"action", drivers::CameraTrigger::action}});
  v.key("source.cameras.trigger_line", cameras.trigger_line);
  v.key("source.cameras.shared_clock", cameras.shared_clock);
  v.key("source.cameras.ptp", cameras.ptp);
  v.key("source.cameras.packet_size", cameras.packet_size);
  v.key("source.cameras.packet_resend", cameras.packet_resend);
  v.choice("source.cameras.layout", cameras.layout,
           {{"two_cameras", drivers::EyeLayout::two_cameras},
            {"side_by_side", drivers::EyeLayout::side_by_side},
            {"interleaved", drivers::EyeLayout::interleaved}});
  v.key("source.cameras.controls", cameras.controls);
  v.file("source.cameras.left_mask", cameras.left_mask);
  v.file("source.cameras.right_mask", cameras.right_mask);

  auto& simulator = c.source.simulator;
  v.key("source.simulator.width", simulator.width);
  v.key("source.simulator.height", simulator.height);
  v.key("source.simulator.focal_px", simulator.focal_px);
  v.key("source.simulator.baseline_m", simulator.baseline_m);
  v.key("source.simulator.camera_height_m", simulator.camera_height_m);
  v.key("source.simulator.pitch_deg", simulator.pitch_deg);
  v.key("source.simulator.raw", simulator.raw);
  v.key("source.simulator.misalign_right_deg", simulator.misalign_right_deg);
  v.key("source.simulator.course", simulator.course);
  v.key("source.simulator.frames", simulator.frames);
  v.key("source.simulator.step_m", simulator.step_m);
  v.key("source.simulator.rate_hz", simulator.rate_hz);
  v.key("source.simulator.every", simulator.every);
  v.key("source.simulator.world_seed", simulator.world_seed);
  v.key("source.simulator.rocks", simulator.rocks);
  v.key("source.simulator.movers", simulator.movers);
  v.key("source.simulator.shadow", simulator.shadow);
  v.key("source.simulator.scene", simulator.scene);
  v.key("source.simulator.railings", simulator.railings);
  v.key("source.simulator.walls", simulator.walls);
  v.key("source.simulator.glass", simulator.glass);
  v.key("source.simulator.fault", simulator.fault);
  v.key("source.simulator.fault_first", simulator.fault_first);
  v.key("source.simulator.fault_frames", simulator.fault_frames);
  v.key("source.simulator.noise_seed", simulator.noise_seed);
  v.key("source.simulator.noise_sigma", simulator.noise_sigma);
  v.key("source.simulator.shot_noise", simulator.shot_noise);
  v.key("source.simulator.motion_blur", simulator.motion_blur);
  v.key("source.simulator.exposure_changes", simulator.exposure_changes);
  v.key("source.simulator.camera", simulator.camera);
  v.key("source.simulator.jpeg_quality", simulator.jpeg_quality);
  v.key("source.simulator.jpeg_spread", simulator.jpeg_spread);
  v.key("source.simulator.defocus_px", simulator.defocus_px);
  v.key("source.simulator.vibration_px", simulator.vibration_px);
  v.key("source.simulator.readout_ms", simulator.readout_ms);
  v.key("source.simulator.shake_px", simulator.shake_px);
  v.key("source.simulator.shake_rows_px", simulator.shake_rows_px);
  v.key("source.simulator.shake_hz", simulator.shake_hz);
  v.key("source.simulator.sun_contrast", simulator.sun_contrast);
  v.key("source.simulator.right_gain", simulator.right_gain);
  v.key("source.simulator.right_gamma", simulator.right_gamma);
  v.key("source.simulator.right_bias", simulator.right_bias);
  v.key("source.simulator.sway_deg", simulator.sway_deg);
  v.key("source.simulator.cache_dir", simulator.cache_dir);
  v.key("source.simulator.cache_limit_gb", simulator.cache_limit_gb);
  v.key("source.simulator.workers", simulator.workers);

  v.key("rectify.scale", c.rectify.scale);
  v.key("rectify.fov_deg", c.rectify.fov_deg);

  auto& stereo = c.stereo;
  v.choice("stereo.prefilter", stereo.prefilter,
           {{"none", stereo::Prefilter::none},
            {"xsobel", stereo::Prefilter::xsobel},
            {"gradients", stereo::Prefilter::gradients}});
  v.key("stereo.prefilter_cap", stereo.prefilter_cap);
  v.key("stereo.window", stereo.window);
  v.key("stereo.window_height", stereo.window_height);
  v.key("stereo.min_disparity", stereo.min_disparity);
  v.key("stereo.num_disparities", stereo.num_disparities);
  v.key("stereo.uniqueness_percent", stereo.uniqueness_percent);
  v.key("stereo.texture_threshold", stereo.texture_threshold);
  v.key("stereo.left_right_tolerance", stereo.left_right_tolerance);
  v.key("stereo.speckle_size", stereo.speckle_size);
  v.key("stereo.speckle_range", stereo.speckle_range);
  v.key("stereo.smoothing", stereo.smoothing);
  v.key("stereo.workers", stereo.workers);

  auto& odometry = c.odometry;
  v.key("odometry.max_features", odometry.max_features);
  v.key("odometry.cell_px", odometry.cell_px);
  v.key("odometry.corner_threshold", odometry.corner_threshold);
  v.key("odometry.min_corner_threshold", odometry.min_corner_threshold);
  v.choice("odometry.corner_image", odometry.corner_image,
           {{"filtered", vo::CornerImage::filtered}, {"intensity", vo::CornerImage::intensity}});
  v.key("odometry.descriptor_window", odometry.descriptor_window);
  v.choice("odometry.consistency", odometry.consistency,
           {{"fixed", vo::Consistency::fixed}, {"range_aware", vo::Consistency::range_aware}});
  v.key("odometry.consistency_delta_m", odometry.consistency_delta_m);
  v.key("odometry.consistency_sigmas", odometry.consistency_sigmas);
  v.key("odometry.match_sigma_px", odometry.match_sigma_px);
  v.key("odometry.match_disparity_sigma_px", odometry.match_disparity_sigma_px);
  v.key("odometry.refine", odometry.refine);
  v.key("odometry.refine_radius_px", odometry.refine_radius_px);
  v.key("odometry.refine_iterations", odometry.refine_iterations);
  v.key("odometry.min_patch_correlation", odometry.min_patch_correlation);
  v.key("odometry.sigma_px", odometry.sigma_px);
  v.key("odometry.disparity_sigma_px", odometry.disparity_sigma_px);
  v.key("odometry.use_key_frame", odometry.use_key_frame);
  v.key("odometry.key_frame_overlap", odometry.key_frame_overlap);
  v.key("odometry.compensate_calibration", odometry.compensate_calibration);
  v.key("odometry.solver_iterations", odometry.solver_iterations);
  v.key("odometry.huber_sigmas", odometry.huber_sigmas);
  v.key("odometry.trim_sigmas", odometry.trim_sigmas);
  v.key("odometry.min_inliers", odometry.min_inliers);
  v.key("odometry.min_eigenvalue_ratio", odometry.min_eigenvalue_ratio);
  v.key("odometry.max_error_ratio", odometry.max_error_ratio);
  v.key("odometry.rival_share", odometry.rival_share);
  v.key("odometry.max_contradiction", odometry.max_contradiction);
  v.key("odometry.max_running_ground", odometry.max_running_ground);
  v.key("odometry.max_uncertainty", odometry.max_uncertainty);
  v.key("odometry.min_mover_points", odometry.min_mover_points);
  v.choice("odometry.after_failure", odometry.after_failure,
           {{"hold", vo::AfterFailure::hold}, {"constant_velocity", vo::AfterFailure::constant_velocity}});

  v.key("lcm.url", c.lcm.url);
  v.key("lcm.delta_channel", c.lcm.delta_channel);
  v.key("lcm.pose_channel", c.lcm.pose_channel);
  v.key("lcm.status_channel", c.lcm.status_channel);
  v.key("lcm.delta_body_channel", c.lcm.delta_body_channel);
  v.key("lcm.images_channel", c.lcm.images_channel);
  v.key("lcm.images_rate_hz", c.lcm.images_rate_hz);
  v.key("lcm.movers_channel", c.lcm.movers_channel);
  v.key("lcm.features_channel", c.lcm.features_channel);
  v.key("lcm.health_channel", c.lcm.health_channel);
  v.key("lcm.command_channel", c.lcm.command_channel);

  v.file("control.socket", c.control.socket);

  v.key("realtime.lock_memory", c.realtime.lock_memory);
  v.key("realtime.stereo_cpu", c.realtime.stereo_cpu);
  v.key("realtime.odometry_cpu", c.realtime.odometry_cpu);
  v.key("realtime.worker_cpu", c.realtime.worker_cpu);
  v.key("realtime.stereo_priority", c.realtime.stereo_priority);
  v.key("realtime.odometry_priority", c.realtime.odometry_priority);
  v.key("realtime.output_priority", c.realtime.output_priority);
  v.key("realtime.catch_up_frames", c.realtime.catch_up_frames);

  v.file("recording.folder", c.recording.folder);
  v.key("recording.at_start", c.recording.at_start);
  v.key("recording.max_file_mb", c.recording.max_file_mb);
  v.key("recording.max_total_mb", c.recording.max_total_mb);
  v.key("recording.queue_mb", c.recording.queue_mb);

  v.key("body.translation_m", c.body.translation_m);
  v.key("body.roll_pitch_yaw_deg", c.body.roll_pitch_yaw_deg);

  v.choice("log.level", c.log_level,
           {{"trace", "trace"}, {"debug", "debug"}, {"info", "info"}, {"warn", "warn"}, {"error", "error"}});
}

}  // namespace cliquevo::daemon
