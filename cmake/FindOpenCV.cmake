# OpenCV by its parts. Debian ships OpenCVConfig.cmake only in libopencv-dev, which draws in every module; the development packages
# of single modules have headers and libraries, and that is all we need.
# find_package(OpenCV REQUIRED COMPONENTS core calib3d) makes the targets OpenCV::core and OpenCV::calib3d.
include(FindPackageHandleStandardArgs)
find_path(OpenCV_INCLUDE_DIR opencv2/core.hpp PATH_SUFFIXES opencv4)
foreach(component ${OpenCV_FIND_COMPONENTS})
  find_library(OpenCV_${component}_LIBRARY opencv_${component})
  if(OpenCV_${component}_LIBRARY AND OpenCV_INCLUDE_DIR)
    set(OpenCV_${component}_FOUND TRUE)
    if(NOT TARGET OpenCV::${component})
      add_library(OpenCV::${component} UNKNOWN IMPORTED)
      set_target_properties(OpenCV::${component} PROPERTIES
        IMPORTED_LOCATION ${OpenCV_${component}_LIBRARY} INTERFACE_INCLUDE_DIRECTORIES ${OpenCV_INCLUDE_DIR})
    endif()
  endif()
  mark_as_advanced(OpenCV_${component}_LIBRARY)
endforeach()
find_package_handle_standard_args(OpenCV REQUIRED_VARS OpenCV_INCLUDE_DIR HANDLE_COMPONENTS)
mark_as_advanced(OpenCV_INCLUDE_DIR)
