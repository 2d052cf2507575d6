# find_package(Plumbline): the targets Plumbline::node, ::geometry, ::adjustment, ::survey, ::block, ::pose, ..., ::testing, and the
# functions plumbline_add_plugin(), plumbline_add_artifacts(), plumbline_test_role().
include(CMakeFindDependencyMacro)
find_dependency(Eigen3)
find_program(FLATC flatc REQUIRED)
# What single libraries need is looked for, and missed only by who links that library.
foreach(package Threads Boost Ceres yaml-cpp pugixml JPEG PNG TIFF OpenSSL TBB nlohmann_json PkgConfig PROJ ZLIB)
  find_package(${package} QUIET)
endforeach()
if(NOT TARGET apriltag::apriltag)  # its targets cannot be defined a second time, in another folder of one project
  set(CMAKE_FIND_PACKAGE_TARGETS_GLOBAL TRUE)
  find_package(apriltag QUIET)
  unset(CMAKE_FIND_PACKAGE_TARGETS_GLOBAL)
endif()
set(plumbline_module_path ${CMAKE_MODULE_PATH})
list(PREPEND CMAKE_MODULE_PATH ${CMAKE_CURRENT_LIST_DIR})
find_package(OpenCV QUIET MODULE COMPONENTS core imgproc calib3d aruco)  # of Plumbline::detect
set(CMAKE_MODULE_PATH ${plumbline_module_path})
if(PkgConfig_FOUND)
  pkg_check_modules(LIBEXIF QUIET IMPORTED_TARGET libexif)  # of Plumbline::images
  pkg_check_modules(IPOPT QUIET IMPORTED_TARGET ipopt)      # of Plumbline::loop
endif()
get_filename_component(PLUMBLINE_PREFIX ${CMAKE_CURRENT_LIST_DIR}/../../.. ABSOLUTE)
set(PLUMBLINE_SCHEMA_DIR ${PLUMBLINE_PREFIX}/share/plumbline/schemas/artifacts)
set(PLUMBLINE_CONFORMANCE_DIR ${PLUMBLINE_PREFIX}/share/plumbline/conformance)
include(${CMAKE_CURRENT_LIST_DIR}/PlumblineTargets.cmake)
include(${CMAKE_CURRENT_LIST_DIR}/PlumblinePlugin.cmake)
include(${CMAKE_CURRENT_LIST_DIR}/PlumblineTesting.cmake)
