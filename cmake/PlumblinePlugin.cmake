# What a plugin is built with: in this tree, and from an installation through find_package(Plumbline).

set(PLUMBLINE_EXPORTS_MAP ${CMAKE_CURRENT_LIST_DIR}/plugin_exports.map)
if(NOT PLUMBLINE_SCHEMA_DIR)
  set(PLUMBLINE_SCHEMA_DIR ${PROJECT_SOURCE_DIR}/schemas/artifacts)
endif()

# plumbline_add_artifacts(NAME SCHEMAS a.fbs b.fbs ...)
# Compiles FlatBuffers schemas to C++: the interface library NAME gives `#include "artifacts/a.hpp"`, which holds the generated
# code and the traits (type name, fingerprint over fields, types and units, embedded schema) of the root table.
function(plumbline_add_artifacts name)
  cmake_parse_arguments(ARG "" "" "SCHEMAS" ${ARGN})
  set(typegen Plumbline::typegen)  # of an installation
  if(TARGET plumbline-typegen)
    set(typegen plumbline-typegen)
  endif()
  set(out ${CMAKE_CURRENT_BINARY_DIR}/${name})
  set(headers)
  set(bfbs_files)
  set(include_flags -I ${PLUMBLINE_SCHEMA_DIR})
  file(MAKE_DIRECTORY ${out}/artifacts)
  foreach(schema ${ARG_SCHEMAS})
    get_filename_component(base ${schema} NAME_WE)
    set(header ${out}/artifacts/${base}.hpp)
    add_custom_command(
      OUTPUT ${header} ${out}/artifacts/${base}_generated.h ${out}/artifacts/${base}.bfbs
      COMMAND ${FLATC} --cpp --cpp-std c++17 --gen-object-api --no-warnings ${include_flags} -o ${out}/artifacts ${schema}
      COMMAND ${FLATC} -b --schema --bfbs-comments --bfbs-builtins --no-warnings ${include_flags} -o ${out}/artifacts ${schema}
      COMMAND sh -c "$<TARGET_FILE:${typegen}> ${out}/artifacts/${base}.bfbs ${base} > ${header}.tmp && mv ${header}.tmp ${header}"
      DEPENDS ${ARG_SCHEMAS} ${typegen}
      COMMENT "Artifact ${base}" VERBATIM)
    list(APPEND headers ${header})
    list(APPEND bfbs_files ${out}/artifacts/${base}.bfbs)
  endforeach()
  add_custom_target(${name}_generate DEPENDS ${headers})
  add_library(${name} INTERFACE)
  add_dependencies(${name} ${name}_generate)
  # SYSTEM: flatc's output is not written for our warnings.
  target_include_directories(${name} SYSTEM INTERFACE $<BUILD_INTERFACE:${out}>)
  target_link_libraries(${name} INTERFACE Plumbline::contract)
  set_target_properties(${name} PROPERTIES PLUMBLINE_BFBS "${bfbs_files}")
endfunction()

# plumbline_add_plugin(FAMILY SOURCES a.cpp ... [LINK lib ...] [FOLDER dir] [LOOPS])
# One shared library build/lib/plumbline/plumbline_FAMILY.so that exports plumbline_plugin() and nothing else. With FOLDER it goes
# there, and is neither found by the program nor installed: for plugins that tests bring. LOOPS: pixels or points are gone through in the
# plugin itself; it is compiled at -O2.
function(plumbline_add_plugin family)
  cmake_parse_arguments(ARG "LOOPS" "FOLDER" "SOURCES;LINK" ${ARGN})
  set(target plumbline_plugin_${family})
  add_library(${target} MODULE ${ARG_SOURCES})
  target_link_libraries(${target} PRIVATE Plumbline::node ${ARG_LINK})
  if(TARGET plumbline_settings)
    target_link_libraries(${target} PRIVATE plumbline_settings)
    if(NOT ARG_LOOPS)
      target_compile_options(${target} PRIVATE ${PLUMBLINE_THIN_OPTIONS})
      plumbline_precompile(${target} THIN)
    else()
      plumbline_precompile(${target})
    endif()
  endif()
  target_compile_definitions(${target} PRIVATE PLUMBLINE_BUILD_ID="${PROJECT_VERSION}")
  # The version script leaves one symbol: without it, inline statics of libraries are shared between plugins.
  target_link_options(${target} PRIVATE -Wl,--version-script=${PLUMBLINE_EXPORTS_MAP} -Wl,--no-undefined -Wl,--build-id=sha1)
  set_target_properties(${target} PROPERTIES
    PREFIX "" OUTPUT_NAME plumbline_${family} POSITION_INDEPENDENT_CODE ON
    CXX_VISIBILITY_PRESET hidden VISIBILITY_INLINES_HIDDEN ON LINK_DEPENDS ${PLUMBLINE_EXPORTS_MAP}
    LIBRARY_OUTPUT_DIRECTORY ${CMAKE_BINARY_DIR}/lib/plumbline)
  if(ARG_FOLDER)
    set_target_properties(${target} PROPERTIES LIBRARY_OUTPUT_DIRECTORY ${ARG_FOLDER})
    return()
  endif()
  set_property(GLOBAL APPEND PROPERTY PLUMBLINE_PLUGINS ${target})
  install(TARGETS ${target} LIBRARY DESTINATION lib/plumbline)
endfunction()
