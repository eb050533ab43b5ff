option(GONIO_PRECOMPILE "Precompile the headers that nearly every file needs; OFF shows missing includes" ON)

# gonio_precompile(TARGET HEADERS_TARGET)
#   Lets TARGET use the headers precompiled once, with the same flags, for HEADERS_TARGET.
function(gonio_precompile target headers)
  if(NOT GONIO_PRECOMPILE)
    return()
  endif()
  target_precompile_headers(${target} REUSE_FROM ${headers})
  # Without it ccache would not recognise what a file with precompiled headers depends on.
  if(CMAKE_CXX_COMPILER_ID STREQUAL "GNU")
    target_compile_options(${target} PRIVATE -fpch-preprocess)
  endif()
endfunction()

# gonio_headers(TARGET HEADERS ... LINK ...)
#   Precompiles headers for others to reuse.
function(gonio_headers target)
  cmake_parse_arguments(PARSE_ARGV 1 arg "" "" "HEADERS;LINK")
  if(NOT GONIO_PRECOMPILE)
    return()
  endif()
  file(CONFIGURE OUTPUT ${target}.cpp CONTENT "// Only the headers precompiled for it matter.\n")
  add_library(${target} OBJECT ${CMAKE_CURRENT_BINARY_DIR}/${target}.cpp)
  target_link_libraries(${target} PRIVATE ${arg_LINK} gonio::options)
  target_precompile_headers(${target} PRIVATE ${arg_HEADERS})
endfunction()

# gonio_module(NAME SOURCES ... PUBLIC ... PRIVATE ...)
#   Defines gonio::NAME from the sources of the current folder. What a header of this module
#   includes goes in PUBLIC; what only its .cpp files need, in PRIVATE.
function(gonio_module name)
  cmake_parse_arguments(PARSE_ARGV 1 arg "" "" "SOURCES;PUBLIC;PRIVATE")
  add_library(gonio_${name} STATIC ${arg_SOURCES})
  add_library(gonio::${name} ALIAS gonio_${name})
  target_include_directories(gonio_${name} PUBLIC ${PROJECT_SOURCE_DIR})
  target_link_libraries(gonio_${name} PUBLIC ${arg_PUBLIC} PRIVATE ${arg_PRIVATE} gonio::options)
  # The headers precompiled are those of modules that know both Eigen and fmt.
  if("fmt::fmt" IN_LIST arg_PRIVATE AND NOT name MATCHES "^(core|drivers)$")
    gonio_precompile(gonio_${name} gonio_headers)
  endif()
endfunction()

# gonio_test(NAME LABEL label SOURCES ... LINK ... [SKIP_RETURN_CODE code] [PROPERTIES ...])
#   One test executable per folder (links are slow on small machines); ctest names are NAME.Suite.Test.
#   The target tests_LABEL builds all executables of a label. A test that ends with `code` was skipped.
#   With GONIO_TEST_SHARDS each executable is so many ctest tests instead, NAME.part1, ...: programs under
#   sanitizers take long to start, and tests that share what they prepare do it once.
#   PROPERTIES are those of ctest.
function(gonio_test name)
  cmake_parse_arguments(PARSE_ARGV 1 arg "" "LABEL;SKIP_RETURN_CODE" "SOURCES;LINK;PROPERTIES")
  set(skip "")
  if(arg_SKIP_RETURN_CODE)
    set(skip SKIP_RETURN_CODE ${arg_SKIP_RETURN_CODE})
  endif()
  add_executable(${name}_test ${arg_SOURCES})
  target_include_directories(${name}_test PRIVATE ${PROJECT_SOURCE_DIR})
  target_link_libraries(${name}_test PRIVATE ${arg_LINK} GTest::gmock_main gonio::options)
  target_compile_definitions(${name}_test PRIVATE
    GONIO_SOURCE_DIR="${PROJECT_SOURCE_DIR}")
  gonio_precompile(${name}_test gonio_test_headers)
  if(NOT TARGET tests_${arg_LABEL})
    add_custom_target(tests_${arg_LABEL})
  endif()
  add_dependencies(tests_${arg_LABEL} ${name}_test)
  if(GONIO_TEST_SHARDS)
    foreach(shard RANGE 1 ${GONIO_TEST_SHARDS})
      math(EXPR index "${shard} - 1")
      add_test(NAME ${name}.part${shard} COMMAND ${name}_test --gtest_brief=1)
      set_tests_properties(${name}.part${shard} PROPERTIES LABELS "${arg_LABEL}" TIMEOUT 1200 ${skip} ${arg_PROPERTIES}
        ENVIRONMENT "GTEST_TOTAL_SHARDS=${GONIO_TEST_SHARDS};GTEST_SHARD_INDEX=${index}")
    endforeach()
  else()
    gtest_discover_tests(${name}_test TEST_PREFIX "${name}." DISCOVERY_TIMEOUT 60
      PROPERTIES LABELS "${arg_LABEL}" TIMEOUT 300 ${skip} ${arg_PROPERTIES})
  endif()
endfunction()
