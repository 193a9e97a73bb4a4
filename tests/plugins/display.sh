# Sourced by the checks of windows: start_display FOLDER starts an X server without a screen, exports DISPLAY and sets `server`,
# its process.
start_display() {
  # Without -noreset it starts over when a window closes, and refuses who comes meanwhile.
  Xvfb -displayfd 3 -noreset -screen 0 1280x900x24 -nolisten tcp 3>"$1/display" 2>/dev/null &
  server=$!
  tries=0
  until [ -s "$1/display" ]; do # it says which display it is when it is ready
    tries=$((tries + 1))
    [ "$tries" -le 300 ] || { echo "Xvfb does not start"; exit 1; }
    sleep 0.1
  done
  DISPLAY=:$(cat "$1/display")
  export DISPLAY
}
