# find_package(Plumbline): the targets Plumbline::node, ::geometry, ::adjustment, ::survey, ::block, ::pose, ..., ::testing, and the
# functions plumbline_add_plugin(), plumbline_add_artifacts(), plumbline_test_role().
include(CMakeFindDependencyMacro)
find_dependency(Eigen3)
find_program(FLATC flatc REQUIRED)
# What single libraries need is looked for, and missed only by who links that library.
foreach(package Threads Boost Ceres yaml-cpp pugixml JPEG PNG TIFF OpenSSL TBB nlohmann_json PkgConfig PROJ ZLIB apriltag)
  find_package(${package} QUIET)
endforeach()
find_package(OpenCV QUIET COMPONENTS core imgproc calib3d aruco)  # of Plumbline::detect
if(PkgConfig_FOUND)
  pkg_check_modules(LIBEXIF QUIET IMPORTED_TARGET libexif)  # of Plumbline::images
endif()
get_filename_component(PLUMBLINE_PREFIX ${CMAKE_CURRENT_LIST_DIR}/../../.. ABSOLUTE)
set(PLUMBLINE_SCHEMA_DIR ${PLUMBLINE_PREFIX}/share/plumbline/schemas/artifacts)
set(PLUMBLINE_CONFORMANCE_DIR ${PLUMBLINE_PREFIX}/share/plumbline/conformance)
include(${CMAKE_CURRENT_LIST_DIR}/PlumblineTargets.cmake)
include(${CMAKE_CURRENT_LIST_DIR}/PlumblinePlugin.cmake)
include(${CMAKE_CURRENT_LIST_DIR}/PlumblineTesting.cmake)
