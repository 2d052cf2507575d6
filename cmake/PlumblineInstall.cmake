# What a plugin outside this tree finds with find_package(Plumbline): the contract, the artifacts, the libraries, and what tests a
# node, as targets Plumbline::NAME with their headers.
include(CMakePackageConfigHelpers)

# What the tests of a node are written with: node_harness.hpp runs one node with inputs made in the test.
add_library(plumbline_testing INTERFACE)
target_include_directories(plumbline_testing INTERFACE
  $<BUILD_INTERFACE:${PROJECT_SOURCE_DIR}/tests/support> $<INSTALL_INTERFACE:include/plumbline/testing>)
target_link_libraries(plumbline_testing INTERFACE plumbline_runtime plumbline_node plumbline_geometry)

foreach(name contract artifacts node folder_files text control linear_algebra geometry statistics least_squares adjustment images geodesy survey survey_files step ifc bundle block_bound block cameras markers detect_tags detect judgement pose surface
             registration register_core adjust_core loop loop_nodes artifact_conversions runtime testing)
  if(NOT TARGET Plumbline::${name})
    add_library(Plumbline::${name} ALIAS plumbline_${name})
  endif()
  set_target_properties(plumbline_${name} PROPERTIES EXPORT_NAME ${name})
  install(TARGETS plumbline_${name} EXPORT PlumblineTargets ARCHIVE DESTINATION lib COMPONENT Development)
endforeach()
# What is said and stated of a result in all adjusters, and in all registrars: theirs is only the way to it. loop_nodes: likewise of planners
# and models of robots.
set_target_properties(plumbline_adjust_core PROPERTIES EXPORT_NAME adjuster)
set_target_properties(plumbline_register_core PROPERTIES EXPORT_NAME registrar)
set_target_properties(plumbline-typegen PROPERTIES EXPORT_NAME typegen)
install(TARGETS plumbline-typegen EXPORT PlumblineTargets RUNTIME DESTINATION bin COMPONENT Development)
install(EXPORT PlumblineTargets NAMESPACE Plumbline:: DESTINATION lib/cmake/Plumbline COMPONENT Development)

set(headers FILES_MATCHING PATTERN "*.h" PATTERN "*.hpp")
install(DIRECTORY framework/include/plumbline DESTINATION include COMPONENT Development)
install(DIRECTORY ${PROJECT_BINARY_DIR}/framework/include/plumbline_artifacts/artifacts DESTINATION include COMPONENT Development ${headers})
# What a library keeps to itself stays here (libraries/private_headers.txt).
file(STRINGS libraries/private_headers.txt private_headers REGEX "[.]hpp$")
set(kept_inside)
foreach(header ${private_headers})
  string(REPLACE "." "[.]" pattern ${header})
  list(APPEND kept_inside REGEX "/libraries/${pattern}$" EXCLUDE)
endforeach()
set_property(DIRECTORY APPEND PROPERTY CMAKE_CONFIGURE_DEPENDS libraries/private_headers.txt)
install(DIRECTORY libraries/ framework/runtime DESTINATION include/plumbline/libraries COMPONENT Development ${headers} ${kept_inside})
install(DIRECTORY plugins/place/adjust plugins/place/register DESTINATION include/plumbline/libraries/place COMPONENT Development ${headers})
install(FILES plugins/build/loop/facade_input.hpp plugins/build/loop/planner_node.hpp plugins/build/loop/robot_node.hpp plugins/build/loop/unplanned_panels.hpp
  DESTINATION include/plumbline/libraries/build/loop COMPONENT Development)
install(DIRECTORY tests/support/ DESTINATION include/plumbline/testing COMPONENT Development ${headers})
install(DIRECTORY schemas/artifacts DESTINATION share/plumbline/schemas COMPONENT Development)
# The kits, and what they draw and read.
foreach(file adjuster.cpp detector.cpp gate.cpp planner.cpp pose_initialiser.cpp registrar.cpp robot.cpp survey_adjuster.cpp survey_reader.cpp survey_writer.cpp
             triangulator.cpp tag36h11_cells.cpp)
  list(APPEND kit_files tests/conformance/${file})
endforeach()
install(FILES ${kit_files} tests/support/test_paths.cpp tests/support/kit_fixtures.cpp tests/unit/detect/tag_cells.hpp
  tests/unit/detect/tag_rendering.hpp tests/unit/detect/tag_rendering.cpp DESTINATION share/plumbline/conformance COMPONENT Development)
install(FILES tests/unit/survey_files/fixtures/code_block_cr_only.gsi tests/unit/survey_files/fixtures/station_coordinates.gsi
  DESTINATION share/plumbline/conformance/fixtures COMPONENT Development)
# What `plumbline new` begins a plugin with.
install(DIRECTORY templates DESTINATION share/plumbline USE_SOURCE_PERMISSIONS)
write_basic_package_version_file(${PROJECT_BINARY_DIR}/PlumblineConfigVersion.cmake COMPATIBILITY SameMinorVersion)
install(FILES cmake/PlumblineConfig.cmake cmake/FindOpenCV.cmake cmake/PlumblinePlugin.cmake cmake/PlumblineTesting.cmake cmake/plugin_exports.map
  ${PROJECT_BINARY_DIR}/PlumblineConfigVersion.cmake DESTINATION lib/cmake/Plumbline COMPONENT Development)
