# cmake -DUSER=... -DLINKS=... -DWORK=... -P run_user.cmake: runs a user's program, and looks at what it links.
cmake_minimum_required(VERSION 3.25)
set(folder ${WORK}/build/${USER})
set(arguments "")
set(wanted "ok")
if(USER STREQUAL "datasheet")  # a hundred samples that look like noise
  set(log "time (s),gyro_x (deg/s)\n")
  foreach(i RANGE 99)
    math(EXPR y "(${i} * ${i} * 7919 + ${i} * 104729) % 1009")
    string(APPEND log "${i},0.${y}\n")
  endforeach()
  file(WRITE ${folder}/log.csv "${log}")
  set(arguments log.csv)
  set(wanted "gyro_x.*N  [0-9.]+ deg/sqrt\\(h\\)")
endif()
execute_process(COMMAND ${folder}/${USER} ${arguments} WORKING_DIRECTORY ${folder}
                RESULT_VARIABLE code OUTPUT_VARIABLE output ERROR_VARIABLE output)
if(NOT code EQUAL 0 OR NOT output MATCHES "${wanted}")
  message(FATAL_ERROR "the user's program of ${USER} ended with ${code} and printed: ${output}")
endif()

execute_process(COMMAND ninja -C ${WORK}/build -t commands -s ${USER}/${USER} OUTPUT_VARIABLE line COMMAND_ERROR_IS_FATAL ANY)
string(REGEX MATCHALL "lib[A-Za-z0-9_+-]+\\.(a|so)" libraries "${line}")
list(TRANSFORM libraries REPLACE "^lib(gyrobudget_)?(.*)\\.(a|so)$" "\\2")
list(REMOVE_DUPLICATES libraries)
if(NOT noise IN_LIST libraries)  # which every component needs
  message(FATAL_ERROR "no link line:\n${line}")
endif()
set(too_much ${libraries})
list(REMOVE_ITEM too_much ${USER} ${LINKS})
if(ceres IN_LIST LINKS)
  list(FILTER too_much EXCLUDE REGEX 
       "^(glog|gflags|spqr|[a-z]*cholmod|c?amd|c?colamd|suitesparseconfig|cxsparse|metis|lapack|[a-z0-9]*blas|atlas)$")  # Ceres' own
endif()
if(too_much)
  message(FATAL_ERROR "${USER} links more than it needs, ${too_much}:\n${line}")
endif()
