% Ask for DEM runs at points, one per row, and wait for their responses, one row each; NaN where a
% run failed. Request and reply are one line: RUNS purpose rows columns values..., values...
function responses = request_runs (points, purpose)
  printf ("RUNS %s %d %d", purpose, rows (points), columns (points));
  printf (" %.17g", points');
  printf ("\n");
  fflush (stdout);
  % fgetl looks at the character behind the line, so an empty line follows every reply.
  reply = "";
  while (isempty (reply))
    reply = fgetl (stdin);
  end
  responses = reshape (sscanf (reply, "%f"), [], rows (points))';
end
