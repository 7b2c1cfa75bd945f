(function(){
"use strict";
var all=function(s,r){return Array.prototype.slice.call((r||document).querySelectorAll(s));};
// Opening an entry that a link points to.
function open(){
  var id=decodeURIComponent(location.hash.slice(1)), e=id&&document.getElementById(id);
  if(e&&e.tagName==="DETAILS"){e.hidden=false;e.open=true;e.scrollIntoView();}
}
addEventListener("hashchange",open); open();
// On paper everything is open.
var closed=[];
addEventListener("beforeprint",function(){closed=all("details:not([open])");closed.forEach(function(e){e.open=true;});});
addEventListener("afterprint",function(){closed.forEach(function(e){e.open=false;});closed=[];});
// Choosing entries by verdict and by word.
var tools=document.getElementById("ledger-tools");
if(tools){
  var entries=all("details.entry"), word=tools.querySelector("input"), chosen="";
  // what an entry can be found by: its words, and the LaTeX of its formulas
  var said=function(e){return e.said||(e.said=(e.textContent+" "+all("math",e).map(function(m){return m.getAttribute("alttext");}).join(" ")).toLowerCase());};
  var show=function(){
    var w=word.value.trim().toLowerCase(), n=0;
    entries.forEach(function(e){
      var on=(!chosen||e.dataset.verdict===chosen)&&(!w||said(e).indexOf(w)>=0);
      e.hidden=!on; if(on)n++;
    });
    tools.querySelector("output").textContent=n+" of "+entries.length+" shown";
  };
  all("button[data-verdict]",tools).forEach(function(b){
    b.addEventListener("click",function(){
      chosen=b.dataset.verdict;
      all("button[data-verdict]",tools).forEach(function(o){o.setAttribute("aria-pressed",o===b);});
      show();
    });
  });
  word.addEventListener("input",show);
  tools.querySelector("button.expand").addEventListener("click",function(){
    var any=entries.some(function(e){return !e.hidden&&!e.open;});
    entries.forEach(function(e){if(!e.hidden)e.open=any;});
  });
  all("a.tile").forEach(function(a){
    a.addEventListener("click",function(){
      var b=tools.querySelector('button[data-verdict="'+a.dataset.verdict+'"]'); if(b)b.click();
    });
  });
  show();
}
// Poles at one speed, chosen with a slider.
var SHAPES={o:"M5,0A5,5 0 1 1 -5,0A5,5 0 1 1 5,0Z",s:"M-4.5,-4.5H4.5V4.5H-4.5Z","^":"M-5,4H5L0,-6Z",v:"M-5,-4H5L0,6Z",
  "<":"M4,-5V5L-6,0Z",">":"M-4,-5V5L6,0Z",D:"M-6,0L0,-6L6,0L0,6Z",P:"M-6,0H6M0,-6V6",X:"M-4.5,-4.5L4.5,4.5M-4.5,4.5L4.5,-4.5",
  p:"M0,-6L5.7,-1.9L3.5,4.9H-3.5L-5.7,-1.9Z",h:"M-6,0L-3,-5.2H3L6,0L3,5.2H-3Z","*":"M0,-6V6M-5.2,-3L5.2,3M-5.2,3L5.2,-3"};
all(".slider").forEach(function(box){
  var d=JSON.parse(box.querySelector("script").textContent), svg=box.querySelector(".map"), range=box.querySelector("input[type=range]");
  var W=Math.min(720,Math.max(340,svg.clientWidth||720)),H=Math.max(300,W*0.58),L=64,R=16,T=14,B=46,NS="http://www.w3.org/2000/svg";
  var x0,x1,y0,y1;
  // Slow and fast poles differ by decades: the real axis is linear up to 10 /s and logarithmic beyond, as in imo poles --plot.
  var S=function(v){var a=Math.abs(v)/10;return (v<0?-1:1)*(a<=1?0.6*a:0.6+Math.log10(a));};
  var X=function(v){return L+(S(v)-S(x0))/(S(x1)-S(x0))*(W-L-R);}, Y=function(v){return T+(y1-v)/(y1-y0)*(H-T-B);};
  svg.setAttribute("viewBox","0 0 "+W+" "+H);
  function el(n,a,t,to){var e=document.createElementNS(NS,n);for(var k in a)e.setAttribute(k,a[k]);if(t!==undefined)e.textContent=t;(to||svg).appendChild(e);return e;}
  function step(s){var p=Math.pow(10,Math.floor(Math.log10(s/5))),m=s/5/p;return p*(m<1.5?1:m<3.5?2:m<7.5?5:10);}
  function ticks(a,b){var s=step(b-a),o=[],v=Math.ceil(a/s)*s;for(;v<=b+1e-9;v+=s)o.push(Math.round(v*1e6)/1e6);return o;}
  function decades(a,b){
    var o=[0],p,m,k;
    for(p=10;p<=1e9;p*=10)for(m=1;m<=3;m+=2)for(k=-1;k<=1;k+=2)if(k*m*p>=a&&k*m*p<=b)o.push(k*m*p);
    return o;
  }
  function minus(v){return String(v).replace("-","\u2212");}
  var axes=el("g",{"class":"axes"});
  // The view holds every pole that a chosen observer has at any speed.
  function view(){
    var on=d.series.filter(function(s,j){return boxes[j].checked;}), re=[0,0], im=[0,0];
    if(!on.length)return;
    on.forEach(function(s){s.poles.forEach(function(at){at.forEach(function(p){
      re=[Math.min(re[0],p[0]),Math.max(re[1],p[0])]; im=[Math.min(im[0],p[1]),Math.max(im[1],p[1])];
    });});});
    x0=Math.min(1.3*re[0],-1); x1=Math.max(1.3*re[1],5); y1=Math.max(1.12*im[1],-1.12*im[0],1); y0=-y1;
    axes.textContent="";
    el("rect",{x:X(0),y:T,width:W-R-X(0),height:H-T-B,fill:"#f3e3e3"},undefined,axes);
    decades(x0,x1).forEach(function(v){
      el("line",{x1:X(v),x2:X(v),y1:T,y2:H-B,stroke:v===0?"#444":"#ddd"},undefined,axes);
      el("text",{x:X(v),y:H-B+16,"font-size":13,"text-anchor":"middle"},minus(v),axes);
    });
    ticks(y0,y1).forEach(function(v){
      el("line",{x1:L,x2:W-R,y1:Y(v),y2:Y(v),stroke:v===0?"#444":"#ddd"},undefined,axes);
      el("text",{x:L-6,y:Y(v)+4,"font-size":13,"text-anchor":"end"},minus(v),axes);
    });
    if(X(0)<W-90)el("text",{x:W-R-6,y:T+16,"font-size":13,"text-anchor":"end"},"unstable",axes);
    el("text",{x:(L+W-R)/2,y:H-8,"font-size":14,"text-anchor":"middle"},"real part (1/s), logarithmic beyond \u00b110",axes);
    el("text",{x:16,y:(T+H-B)/2,"font-size":14,"text-anchor":"middle",transform:"rotate(-90 16 "+(T+H-B)/2+")"},"imaginary part (rad/s)",axes);
  }
  var boxes=all("input[type=checkbox]",box);
  var groups=d.series.map(function(s,j){
    var g=el("g",{fill:"none",stroke:s.color,"stroke-width":2,"class":"poles"});
    s.poles[0].forEach(function(){el("path",{d:SHAPES[s.mark]},undefined,g);});
    el("path",{d:SHAPES[s.mark],fill:"none",stroke:s.color,"stroke-width":2,transform:"translate(9 9)"},undefined,all(".key",box)[j]);
    boxes[j].addEventListener("change",function(){view();draw();});
    return g;
  });
  var out=box.querySelector("output"), say=box.querySelector(".say");
  function draw(){
    var k=+range.value, told=[];
    out.textContent=minus(d.omega[k])+" rad/s"; range.setAttribute("aria-valuetext",out.textContent);
    d.series.forEach(function(s,j){
      groups[j].style.display=boxes[j].checked?"":"none";
      if(!boxes[j].checked)return;
      s.poles[k].forEach(function(p,i){
        groups[j].childNodes[i].setAttribute("transform","translate("+X(p[0]).toFixed(2)+" "+Y(p[1]).toFixed(2)+")");
      });
      var worst=Math.max.apply(null,s.poles[k].map(function(p){return p[0];}));
      told.push(s.label+": rightmost pole at "+minus(worst.toFixed(2))+" /s"+(worst>0.005?" (unstable)":""));
    });
    say.textContent=told.length?told.join("; ")+".":"";
  }
  range.addEventListener("input",draw);view();draw();
});
})();
