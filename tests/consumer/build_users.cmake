# cmake -DBUILD=... -DSOURCE=... -DWORK=... -DUSERS=... -DINSTALLED=... -DEXAMPLES=... -P build_users.cmake
# Installs, and builds the users.
function(must)
  execute_process(COMMAND ${ARGV} RESULT_VARIABLE code OUTPUT_VARIABLE output ERROR_VARIABLE output)
  if(NOT code EQUAL 0)
    message(FATAL_ERROR "failed: ${ARGV}\n${output}")
  endif()
endfunction()
file(REMOVE_RECURSE ${WORK})
must(${CMAKE_COMMAND} --install ${BUILD} --prefix ${WORK}/prefix)
must(${CMAKE_COMMAND} -S ${SOURCE} -B ${WORK}/build -G Ninja -DCMAKE_PREFIX_PATH=${WORK}/prefix
     -DUSERS=${USERS} -DINSTALLED=${INSTALLED} -DEXAMPLES=${EXAMPLES})
must(${CMAKE_COMMAND} --build ${WORK}/build)
