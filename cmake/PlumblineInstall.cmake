# What a plugin outside this tree finds with find_package(Plumbline): the contract, the artifacts, the libraries, and what tests a
# node, as targets Plumbline::NAME with their headers.
include(CMakePackageConfigHelpers)

# What the tests of a node are written with: node_harness.hpp runs one node with inputs made in the test.
add_library(plumbline_testing INTERFACE)
target_include_directories(plumbline_testing INTERFACE
  $<BUILD_INTERFACE:${PROJECT_SOURCE_DIR}/tests/support> $<INSTALL_INTERFACE:include/plumbline/testing>)
target_link_libraries(plumbline_testing INTERFACE plumbline_runtime plumbline_node plumbline_geometry)

foreach(name contract artifacts node folder_files text control geometry statistics least_squares adjustment images geodesy survey survey_files ifc block_bound block markers judgement pose surface
             artifact_conversions runtime testing)
  if(NOT TARGET Plumbline::${name})
    add_library(Plumbline::${name} ALIAS plumbline_${name})
  endif()
  set_target_properties(plumbline_${name} PROPERTIES EXPORT_NAME ${name})
  install(TARGETS plumbline_${name} EXPORT PlumblineTargets ARCHIVE DESTINATION lib COMPONENT Development)
endforeach()
set_target_properties(plumbline-typegen PROPERTIES EXPORT_NAME typegen)
install(TARGETS plumbline-typegen EXPORT PlumblineTargets RUNTIME DESTINATION bin COMPONENT Development)
install(EXPORT PlumblineTargets NAMESPACE Plumbline:: DESTINATION lib/cmake/Plumbline COMPONENT Development)

set(headers FILES_MATCHING PATTERN "*.h" PATTERN "*.hpp")
install(DIRECTORY framework/include/plumbline DESTINATION include COMPONENT Development)
install(DIRECTORY ${PROJECT_BINARY_DIR}/framework/include/plumbline_artifacts/artifacts DESTINATION include COMPONENT Development ${headers})
install(DIRECTORY libraries/ framework/runtime DESTINATION include/plumbline/libraries COMPONENT Development ${headers})
install(DIRECTORY tests/support/ DESTINATION include/plumbline/testing COMPONENT Development ${headers})
install(DIRECTORY schemas/artifacts DESTINATION share/plumbline/schemas COMPONENT Development)
# The kits that need nothing but the nodes under test.
install(FILES tests/conformance/adjuster.cpp tests/conformance/pose_initialiser.cpp tests/conformance/registrar.cpp
  tests/conformance/triangulator.cpp
  tests/conformance/survey_adjuster.cpp tests/support/test_paths.cpp DESTINATION share/plumbline/conformance COMPONENT Development)
write_basic_package_version_file(${PROJECT_BINARY_DIR}/PlumblineConfigVersion.cmake COMPATIBILITY SameMinorVersion)
install(FILES cmake/PlumblineConfig.cmake cmake/PlumblinePlugin.cmake cmake/PlumblineTesting.cmake cmake/plugin_exports.map
  ${PROJECT_BINARY_DIR}/PlumblineConfigVersion.cmake DESTINATION lib/cmake/Plumbline COMPONENT Development)
