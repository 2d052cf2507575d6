# Settings every target of the project shares, and the two functions that apply them.

set(CMAKE_CXX_STANDARD 20)
set(CMAKE_CXX_STANDARD_REQUIRED ON)
set(CMAKE_CXX_EXTENSIONS OFF)
set(CMAKE_C_STANDARD 11)
set(CMAKE_C_EXTENSIONS OFF)
set(CMAKE_POSITION_INDEPENDENT_CODE ON)
set(CMAKE_CXX_VISIBILITY_PRESET hidden)
set(CMAKE_VISIBILITY_INLINES_HIDDEN ON)
set(CMAKE_EXPORT_COMPILE_COMMANDS ON)
if(NOT CMAKE_BUILD_TYPE)
  set(CMAKE_BUILD_TYPE Release)
endif()
# -O2 with assertions of our own kept as exceptions; -O3 gains nothing we measured and compiles slower.
set(CMAKE_CXX_FLAGS_RELEASE "-O2 -DNDEBUG")

set(CMAKE_RUNTIME_OUTPUT_DIRECTORY ${CMAKE_BINARY_DIR}/bin)
set(CMAKE_LIBRARY_OUTPUT_DIRECTORY ${CMAKE_BINARY_DIR}/lib)
set(CMAKE_ARCHIVE_OUTPUT_DIRECTORY ${CMAKE_BINARY_DIR}/lib)

find_program(CCACHE_PROGRAM ccache)
if(CCACHE_PROGRAM)
  # What ccache has to be allowed, or it keeps nothing that takes a precompiled header. Told by the compiler what a file
  # reads, it need not preprocess every file that it has not seen.
  # How much memory the compiler takes changes nothing that it writes.
  set(CMAKE_C_COMPILER_LAUNCHER env CCACHE_SLOPPINESS=pch_defines,time_macros CCACHE_DEPEND=1 CCACHE_IGNOREOPTIONS=--param=ggc-* ${CCACHE_PROGRAM})
  set(CMAKE_CXX_COMPILER_LAUNCHER ${CMAKE_C_COMPILER_LAUNCHER})
endif()

option(PLUMBLINE_ASAN "Build with AddressSanitizer and UndefinedBehaviorSanitizer" OFF)

add_library(plumbline_settings INTERFACE)
target_compile_options(plumbline_settings INTERFACE
  -Wall -Wextra -Wpedantic -Wshadow -Wconversion -Wno-sign-conversion -Werror
  # Same bits on every machine: no fused multiply-add unless written. Never -march or -mavx: Debian's OpenGV is
  # built for the baseline and Eigen's alignment is part of its ABI.
  -ffp-contract=off)
# GCC looks through its memory for what it needs no more each time that has grown by 128 MB: a sixth of its time (a page of the report:
# 9.8 s of processor time, 8.2 without, and a fifth more memory). Where there are 3 GB for each compiler it begins at a gigabyte.
cmake_host_system_information(RESULT memory QUERY TOTAL_PHYSICAL_MEMORY)
cmake_host_system_information(RESULT cores QUERY NUMBER_OF_LOGICAL_CORES)
math(EXPR memory_each "${memory} / (${cores} + 2)")  # MB; ninja begins two more than there are cores
if(CMAKE_CXX_COMPILER_ID STREQUAL "GNU" AND memory_each GREATER 3000)
  set(PLUMBLINE_MEMORY_OPTIONS --param=ggc-min-heapsize=1000000)
  target_compile_options(plumbline_settings INTERFACE ${PLUMBLINE_MEMORY_OPTIONS})
endif()
if(PLUMBLINE_ASAN)
  # With sanitizers GCC warns of what is not there (stringop-overread in flatbuffers' headers).
  # -O1 and without the checks of every pointer: GCC 12 needs 54 s instead of 6.6 s for a file full of Eigen otherwise.
  target_compile_options(plumbline_settings INTERFACE -O1 -g1 -fsanitize=address,undefined
    -fno-sanitize=null,alignment,vptr,object-size -fno-omit-frame-pointer -Wno-error)
  target_link_options(plumbline_settings INTERFACE -fsanitize=address,undefined)
  # Under AddressSanitizer Eigen would allocate in another way than Debian's OpenGV, which frees what we made and we what
  # it made; malloc is aligned there too.
  target_compile_definitions(plumbline_settings INTERFACE EIGEN_MALLOC_ALREADY_ALIGNED=1)
endif()

# What costs time when it runs lies in libraries/; nodes, pages and tests cost it when they are compiled: at -O1 a sixth less than at
# -O2, at -Og another 12 (a page) to 19 % (a test). A run of the demo takes 3 % more of the processor so, and gives the same bits.
set(PLUMBLINE_THIN_OPTIONS $<$<CONFIG:Release>:-Og>)

# Precompiled headers for libraries and plugins: reading them costs a sixth of the compiler's time. Only the standard library, Eigen and
# libfmt: what more costs each file to load is what it saves most. Not where each file compiles by itself (preset `debug`).
if(PLUMBLINE_UNITY)
  find_package(Eigen3 REQUIRED NO_MODULE)
  foreach(name plumbline_headers plumbline_headers_thin)
    add_library(${name} OBJECT ${CMAKE_CURRENT_LIST_DIR}/precompiled.cpp)
    target_link_libraries(${name} PRIVATE plumbline_settings Eigen3::Eigen)
    target_include_directories(${name} PRIVATE ${PROJECT_SOURCE_DIR}/libraries)
    target_precompile_headers(${name} PRIVATE <geometry/linear_algebra/eigen_once.hpp> <algorithm> <array> <charconv> <cmath>
      <filesystem> <fmt/core.h> <fstream> <functional> <map> <memory> <mutex> <numeric> <optional> <set> <sstream> <stdexcept> <string> <vector>)
  endforeach()
  target_compile_options(plumbline_headers_thin PRIVATE ${PLUMBLINE_THIN_OPTIONS})
endif()

# plumbline_precompile(TARGET [THIN])
# Gives a library or plugin the precompiled headers of its options; tests' libraries have options of their own. The headers leave Eigen's
# kernels to plumbline_linear_algebra.
function(plumbline_precompile target)
  cmake_parse_arguments(ARG "THIN" "" "" ${ARGN})
  if(NOT PLUMBLINE_UNITY OR CMAKE_CURRENT_SOURCE_DIR MATCHES "^${PROJECT_SOURCE_DIR}/tests/")
    return()
  endif()
  # GCC 12 warns of texts that are put together where <string> is precompiled (its bug 105651 and kin): of what is not there.
  if(NOT "${target}" STREQUAL "plumbline_linear_algebra")
    target_link_libraries(${target} PRIVATE plumbline_linear_algebra)
  endif()
  target_compile_options(${target} PRIVATE -Wno-array-bounds -Wno-restrict -Wno-stringop-overflow -Wno-stringop-overread)
  if(ARG_THIN)
    target_precompile_headers(${target} REUSE_FROM plumbline_headers_thin)
  else()
    target_precompile_headers(${target} REUSE_FROM plumbline_headers)
  endif()
endfunction()

# plumbline_add_library(NAME SOURCES a.cpp ... [LINK lib ...] [LOOPS])
# A static library with the project's settings whose headers are included as "folder/header.hpp", from libraries/ or framework/.
# LOOPS, for one of plugins/: it goes through pixels or points itself and is compiled at -O2 all the same.
function(plumbline_add_library name)
  cmake_parse_arguments(ARG "LOOPS" "" "SOURCES;LINK" ${ARGN})
  add_library(${name} STATIC ${ARG_SOURCES})
  if(CMAKE_CURRENT_SOURCE_DIR MATCHES "^${PROJECT_SOURCE_DIR}/plugins/" AND NOT ARG_LOOPS)
    target_compile_options(${name} PRIVATE ${PLUMBLINE_THIN_OPTIONS})
    plumbline_precompile(${name} THIN)
  else()
    plumbline_precompile(${name})
  endif()
  if(CMAKE_CURRENT_SOURCE_DIR MATCHES "^${PROJECT_SOURCE_DIR}/libraries/")
    set_property(GLOBAL APPEND PROPERTY PLUMBLINE_LIBRARIES ${name})
  endif()
  target_include_directories(${name} PUBLIC
    $<BUILD_INTERFACE:${PROJECT_SOURCE_DIR}/libraries> $<BUILD_INTERFACE:${PROJECT_SOURCE_DIR}/framework>
    $<INSTALL_INTERFACE:include/plumbline/libraries>)
  # libfmt by its name: its CMake target would put a definition on every command line.
  target_link_libraries(${name} PUBLIC ${ARG_LINK} PRIVATE fmt $<BUILD_INTERFACE:plumbline_settings>)
  if(PLUMBLINE_ASAN)  # whoever links it from the installation needs the sanitizers' part
    target_link_options(${name} PUBLIC -fsanitize=address,undefined)
  endif()
endfunction()

# plumbline_add_test(NAME SOURCES a.cpp ... [LINK lib ...] [TIMEOUT seconds])
# A GoogleTest program; every TEST in it becomes one ctest entry. `test_support.hpp` finds fixtures and test data.
function(plumbline_add_test name)
  cmake_parse_arguments(ARG "" "TIMEOUT" "SOURCES;LINK" ${ARGN})
  if(NOT ARG_TIMEOUT)
    set(ARG_TIMEOUT 600)
  endif()
  add_executable(${name} ${ARG_SOURCES})
  target_include_directories(${name} PRIVATE ${PROJECT_SOURCE_DIR}/tests/support)
  target_link_libraries(${name} PRIVATE ${ARG_LINK} plumbline_linear_algebra plumbline_test_paths plumbline_settings GTest::gtest_main)
  target_compile_options(${name} PRIVATE ${PLUMBLINE_THIN_OPTIONS})
  target_precompile_headers(${name} REUSE_FROM plumbline_test_headers)
  set_target_properties(${name} PROPERTIES RUNTIME_OUTPUT_DIRECTORY ${CMAKE_BINARY_DIR}/tests)
  gtest_discover_tests(${name} TEST_PREFIX ${name}. DISCOVERY_MODE PRE_TEST DISCOVERY_TIMEOUT 120 PROPERTIES TIMEOUT ${ARG_TIMEOUT})
endfunction()

# plumbline_embed_texts(HEADER NAMESPACE STRUCT ARRAY FOLDER)
# Writes a header with the YAML files of a folder: `inline constexpr STRUCT ARRAY[]` of {name, yaml}.
function(plumbline_embed_texts header namespace struct array folder)
  file(GLOB files CONFIGURE_DEPENDS ${folder}/*.yaml)
  set(table "// Generated from the files of ${folder}.\n#pragma once\nnamespace ${namespace} {\nstruct ${struct} {\n  const char* name;\n  const char* yaml;\n};\ninline constexpr ${struct} ${array}[] = {\n")
  foreach(file ${files})
    get_filename_component(name ${file} NAME_WE)
    file(READ ${file} text)
    string(APPEND table "    {\"${name}\", R\"yaml(${text})yaml\"},\n")
    set_property(DIRECTORY APPEND PROPERTY CMAKE_CONFIGURE_DEPENDS ${file})
  endforeach()
  string(APPEND table "};\n}  // namespace ${namespace}\n")
  file(CONFIGURE OUTPUT ${header} CONTENT "${table}" @ONLY)
endfunction()

# plumbline_embed_files(HEADER NAMESPACE NAME FILE [NAME FILE ...])
# Writes a header with files word for word: `inline constexpr const char* NAME`. Scripts and styles of pages are files of their own, so
# that an editor and a test can read them.
function(plumbline_embed_files header namespace)
  set(content "// Made from the files that are named here.\n#pragma once\n\nnamespace ${namespace} {\n\n")
  while(ARGN)
    list(POP_FRONT ARGN name file)
    file(READ ${file} text)
    set_property(DIRECTORY APPEND PROPERTY CMAKE_CONFIGURE_DEPENDS ${CMAKE_CURRENT_SOURCE_DIR}/${file})
    string(APPEND content "/// ${file}\ninline constexpr const char* ${name} = R\"plumbline(${text})plumbline\";\n")
  endwhile()
  file(WRITE ${header}.new "${content}\n}  // namespace ${namespace}\n")
  file(COPY_FILE ${header}.new ${header} ONLY_IF_DIFFERENT)
endfunction()

# plumbline_compile_alone(a.cpp ...)
# Files that are not compiled together with others of their target (CMAKE_UNITY_BUILD): their own names would meet.
function(plumbline_compile_alone)
  set_source_files_properties(${ARGN} PROPERTIES SKIP_UNITY_BUILD_INCLUSION ON)
endfunction()
