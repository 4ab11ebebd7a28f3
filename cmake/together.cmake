# Sources that name nothing alike in their unnamed namespaces, six at a time: each line compiles as one, so that what they
# instantiate of templates is compiled once, which takes a third of the compiler's time away. What is not listed compiles alone.
set(MAJAK_TOGETHER_majak_draw
  "chart comparison_figure demonstration_figures face_beams face_cells face_dynamics"
  "demonstration_report face_figure face_objects face_relations face_rooms face_segments"
  "face_solid faces figure_ackermann figure_dead_reckoning figure_forward figure_mirror"
  "figure_differential figure_dogma figure_inflation figure_monte_carlo figure_office figure_park"
  "figure_drift figure_kalman figure_omnidirectional figure_ring"
  "figure_markov figure_slam figure_solid figure_sonar findings map_figure"
  "figure_segments map_layers mapped_drive raster report report_page"
  "figure_triangulation site_view sketch slam_figures solid_view sonar_drive"
  "figure_trilateration stroke_font svg table2_page trajectory_figure"
  "thesis_figures topology_figure")
set(MAJAK_TOGETHER_majak_map
  "contours distance_field distance_transform door_gaps draw_scans dynamics"
  "doors echo_response edits elevation exclusive_assignment forward_cells"
  "forward_fit forward_grid inflation known_map laser_mounting occupancy_grid"
  "intensity planes rectangles region_outline relations returns"
  "object_shape raised_walls room_labels route scan_choice segment_ends"
  "objects segment_gaps segment_map segment_raster segments solid"
  "pieces segment_refinement solid_map solid_points surface_bits surfel_map"
  "topology trajectory visits")
set(MAJAK_TOGETHER_majak_io
  "atomic_file beacon_map byte_codec byte_stream carmen_habits carmen_reader"
  "carmen_record carmen_writer cola_source descriptor g2o gps_beside"
  "known_map_files landmark_file line_reader lms_source log_summary mcap_log_writer"
  "map_files mcap_reader no_return number options_file piece_reader"
  "mcap_writer nmea_log png recording ros2_sqlite ros_log"
  "player_log ros_messages ros_scan ros_source ros_survey ros_transforms"
  "ros1_bag segment_files segment_reader serial_port site_file_read site_file_write"
  "site_graph site_record solid_gltf solid_ply solid_vrml source"
  "sqlite summary tcp tum unpack victoria_park"
  "topology_files view_records word_reader")
set(MAJAK_TOGETHER_majak_sim
  "buildings doors floor_plans known_map park pilot"
  "furnished_room plan robot solid_simulator solid_world surveyed_site"
  "satellites solid_places tour"
  "simulator world")
set(MAJAK_TOGETHER_majak_localize
  "beacons belief_weighing dead_reckoning gps_pieces kalman_inputs kalman_smoother"
  "find_and_track place pose_fit scan_feed tracking_errors"
  "kalman monte_carlo")
set(MAJAK_TOGETHER_majak_motion
  "calibration drive drive_correction drive_log encoder habit"
  "odometry_fit odometry_model path_uncertainty seen_steps slip umbmark"
  "step_noise wheel_matrix wheel_noise wheel_path wheel_step")
set(MAJAK_TOGETHER_majak_match
  "beam_model beams cell_attributes correlative global_search jackknife"
  "likelihood_field map_surfaces point_to_line range_offset")
set(MAJAK_TOGETHER_test_map
  "contours_test distance_field_test doors_test dynamics_test edits_test elevation_test"
  "distance_transform_test exclusive_assignment_test forward_grid_test known_map_test laser_mounting_test objects_test"
  "inflation_test intensity_test occupancy_grid_test planes_test raised_walls_test rectangles_test"
  "ray_test relations_test room_labels_test segment_gaps_test segment_map_test segment_refinement_test"
  "returns_test route_test segment_raster_test shared_array_test solid_points_test surfel_map_test"
  "segments_test tiles_test trajectory_test visits_test")
set(MAJAK_TOGETHER_test_io
  "atomic_file_test byte_codec_test carmen_record_test cola_over_tcp_test known_map_files_test landmark_file_test"
  "beacon_map_test byte_stream_test line_reader_test log_summary_test mcap_log_writer_test"
  "carmen_reader_test no_return_test number_test open_log_test png_test"
  "carmen_writer_test ros_messages_test ros_scan_test ros_transforms_test segment_files_test segment_reader_test"
  "g2o_test solid_files_test stamp_order_test tum_test unpack_test view_records_test"
  "mcap_test summary_test")
set(MAJAK_TOGETHER_test_slam
  "chain_test ekf_slam_test expectation_maximization_test front_end_test joint_compatibility_test landmark_graph_test"
  "graph_slam_test hybrid_test lu_milios_test motion_input_test range_bias_test"
  "joint_refinement_test rao_blackwellized_test reoptimise_test ways_test"
  "loop_closing_test revisits_test wheel_numbers_test")
set(MAJAK_TOGETHER_test_sensor
  "cola_identity_test cola_scan_test lms291_test lms_driver_test scan_clock_test turn_merger_test"
  "cola_session_test lms_recovery_test")
set(MAJAK_TOGETHER_test_match
  "beam_model_test beams_test cell_attributes_test correlative_test global_search_test jackknife_test"
  "likelihood_field_test map_surfaces_test")
set(MAJAK_TOGETHER_test_localize
  "beacons_test dead_reckoning_test find_and_track_test floor_colour_test gps_pieces_test markov_test"
  "kalman_beacons_test place_test pose_bins_test scan_feed_test tracking_errors_test"
  "kalman_test plausibility_test")
set(MAJAK_TOGETHER_majak_beacon
  "association fix local_frame nmea pseudorange reflectors"
  "resection trunks")
set(MAJAK_TOGETHER_majak_graph
  "block_cholesky block_structure dense_kernels initialize marginals normal_equations"
  "optimize pose_graph")
set(MAJAK_TOGETHER_test_beacon
  "local_frame_test nmea_test pseudorange_test reflectors_test simulated_reflectors_test triangulation_test"
  "resection_test trilateration_test trunks_test")
set(MAJAK_TOGETHER_test_filter
  "histogram_test landmark_filter_test resampling_test scalar_kalman_test"
  "pose_filter_test pose_histogram_test")
set(MAJAK_TOGETHER_test_methods
  "car_test kalman_with_laser_test mappers_test markov_row_test methods_test")
